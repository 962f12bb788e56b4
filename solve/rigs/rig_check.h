// What a rig can tell from a take, and what not: which AUs its markers see too weakly, which they confuse, whether the
// stabilisers hold the head, whether the rig is this take's at all. Columns are compared after the head's pose is taken
// out of them (a jaw thrust that the markers cannot tell from a nod is not observed), with the markers that the take
// really shows.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

struct RigCheckOptions {
  double confused_cosine = 0.9;     ///< two AUs more alike are confounded, (0, 1)
  double largest_deviation = 0.15;  ///< an AU whose intensity is less certain is weakly observed, > 0
  double least_noise_mm = 0.2;      ///< per axis, > 0
  double unrest_mm = 1.5;           ///< a stabiliser that moves more against the head (rms) does not hold it, > 0
  AuSolverOptions solve;
};

struct AuCheck {
  std::string au;
  double deviation = 0;        ///< standard deviation of its intensity, all AUs and the pose being unknown
  double alone_deviation = 0;  ///< if it alone were unknown
  std::string most_like;       ///< the other AU that it is most like
  double cosine = 0;           ///< to that one
  double seen_share = 0;       ///< of its displacement's energy, on markers that the take shows
  double peak = 0;             ///< 98th percentile of its intensity in the take
  double at_bound_share = 0;   ///< of the frames
  bool weak = false;
};

struct ConfusedPair {
  std::string first, second;
  double cosine = 0;
};

struct RigCheck {
  std::vector<AuCheck> aus;
  std::vector<ConfusedPair> confused;  ///< most alike first
  Eigen::MatrixXd cosines;             ///< K x K, pose taken out
  double condition = 0;                ///< of their matrix
  double noise_mm = 0;                 ///< what the rig leaves of the take, per axis
  double residual_rms_mm = 0;          ///< per marker
  std::size_t frames = 0, solved = 0;
  std::vector<std::string> unknown_markers;  ///< in the take, not in the rig
  std::vector<std::string> missing_markers;  ///< in the rig, not in the take or never seen
  std::vector<double> unrest_mm;             ///< M
  std::vector<std::string> problems;         ///< the rig cannot be used for this take; one sentence each
  std::vector<std::string> warnings;
};

/// Throws UserError where less than half of the markers, or fewer than 3 stabilisers, are in the take.
RigCheck check_rig(const Rig& rig, const TakeFrames& take, const RigCheckOptions& options = {});

}  // namespace risorius
