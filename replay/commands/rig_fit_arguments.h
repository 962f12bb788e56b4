// What `rig fit` and `rig calibrate` share: a neutral, the generic face that is fitted to it, and the landmark map.
#pragma once

#include <string>

#include "replay/commands/take_arguments.h"
#include "replay/pipeline/rig_neutral.h"
#include "solve/faces/rig_fit.h"

namespace risorius {

struct RigFitArguments {
  std::string face = "builtin", neutral, landmarks, output, name;
  bool is_generic = false;  ///< the face is not bent to the actor
  TakeArguments take;

  void add_to(CLI::App& command);
  /// Reads neutral and face and fits; the rig has its name and says where it comes from. Throws UserError.
  RigFitResult fit() const;
};

/// Prints to stderr why the neutral may be a bad one: few frames, or a face that moves. `given`: as the user named it.
void print_warnings(const ChosenNeutral& chosen, const NeutralPlace& place, const std::string& given);

/// Prints the fit's warnings to stderr.
void print_warnings(const RigFitResult& fit);

}  // namespace risorius
