// A take as a rig explains it: per frame the intensities, and where each marker is against the neutral in the head's
// frame. What the refinement and the checks of rigs work on.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/rigid_alignment.h"
#include "solve/au_solver_options.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// A take in memory: its frames after despiking, with gaps left missing (filled markers tell nothing new).
struct TakeFrames {
  std::string place;  ///< for messages
  MarkerSet markers;
  std::vector<MarkerFrame> frames;
};

/// One solved frame.
struct ExplainedFrame {
  Eigen::VectorXd x;                 ///< K, 0 to the bounds
  std::vector<char> observed;        ///< K
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x M from the neutral, head frame; 0 where not measured
  Eigen::Matrix3Xd residual_mm;      ///< 3 x M, what the AUs leave of it; 0 where not measured
  Eigen::VectorXd measured;          ///< M, 1 or 0
  Eigen::VectorXd weight;            ///< M, the solver's final weight, 0 where not measured
  RigidTransform world_from_head;
  double share_of_time = 0;  ///< seconds that this frame stands for
  std::size_t index = 0;     ///< in the take
};

/// Frames by what became of them, entry by SolverStatus.
using StatusTally = std::array<std::size_t, kSolverStatusCount>;

/// Solves the frames in order and hands on those that have AUs. Throws UserError where the rig does not know the
/// markers. `frames` of one marker set.
StatusTally explain_take(const Rig& rig, const TakeFrames& take, const AuSolverOptions& options,
                         const std::function<void(const ExplainedFrame&)>& sink);

}  // namespace risorius
