// Stabilisers chosen anew by takes: a marker holds the head if the takes show it at rest in the frame of the majority
// (marker_rigidity.h) and the rig's AUs hardly move it. Foreheads rise with brows, and only a take shows how far.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

struct StabiliserChoice {
  Eigen::VectorXd weight;            ///< M, 0 to 1: the new weights
  std::vector<std::size_t> dropped;  ///< stabilisers that move with the face
  std::vector<std::size_t> added;
};

/// `unrest_mm` (M): of each marker in the takes, the largest; NaN where not known. The old weights where none of the
/// stabilisers moves by `moving_mm`, or where no better choice holds the head still.
StabiliserChoice choose_by_unrest(const Rig& rig, const Eigen::VectorXd& unrest_mm, double moving_mm = 1.5);

}  // namespace risorius
