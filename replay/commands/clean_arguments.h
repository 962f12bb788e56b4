// What `clean` and `plot repair` have in common: which take, and how it is repaired.
#pragma once

#include <string>
#include <vector>

#include "replay/commands/take_arguments.h"
#include "replay/pipeline/clean_take.h"

namespace risorius {

struct CleanArguments {
  std::string take, rig;
  double max_gap_s = 0;
  std::vector<std::string> needed_markers;  ///< asked for before anything is repaired
  CleanOptions options;
  TakeArguments take_arguments;

  void add_to(CLI::App& command);
  /// Reads and repairs, with a progress line. `set` receives the take's markers, in mm and LUF. Throws UserError.
  CleanedTake run(MarkerSet& set);
};

}  // namespace risorius
