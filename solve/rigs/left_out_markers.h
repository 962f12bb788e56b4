// How well a rig foresees markers that it was not shown: hide some, solve the others, and compare where the face is
// said to be there with where the hidden markers were. Unlike the residual of the markers that were fitted, this cannot
// be made small by more AUs alone.
#pragma once

#include <vector>

#include "solve/au_solver_options.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

/// Sums over the hidden markers of all frames that could be solved with and without them, in mm^2.
struct LeftOutEnergy {
  double moved_mm2 = 0;  ///< from the neutral, in the head pose of all markers
  double left_mm2 = 0;   ///< from what the others foretell
  double samples = 0;

  double explained() const noexcept { return moved_mm2 > 0 ? 1 - left_mm2 / moved_mm2 : 0; }
};

/// Markers (of the rig, no stabilisers) in `count` groups, each all over the face; every marker is in one of them.
/// count >= 2.
std::vector<std::vector<std::size_t>> marker_folds(const Rig& rig, std::size_t count);

/// Hides each group in turn. Throws UserError where the rig does not know the take's markers.
LeftOutEnergy left_out_energy(const Rig& rig, const TakeFrames& take,
                              const std::vector<std::vector<std::size_t>>& hidden_groups,
                              const AuSolverOptions& options = {});

}  // namespace risorius
