// One movement in a recording: d_t = a_t e, a time course times a displacement field, found robustly by alternating
// least squares. For the calibration of rigs (rig_calibrate.h).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace risorius {

/// A recording in the head frame: displacement from the neutral, 3 x M per frame, with a weight per marker (0: not
/// measured; the displacement is not read).
struct Displacements {
  std::vector<Eigen::Matrix3Xd> d_mm;
  std::vector<Eigen::VectorXd> weight;
};

struct RankOneMotion {
  Eigen::Matrix3Xd field_mm;  ///< e: 3 x M, at amplitude 1, the held maximum
  Eigen::VectorXd amplitude;  ///< a, per frame
  Eigen::VectorXd evidence;   ///< per marker: sum of weight * amplitude^2
  double noise_mm = 0;        ///< what is left unexplained, per axis
};

/// `hold_share` of the greatest amplitude counts as held, (0, 1). At least one frame.
RankOneMotion find_rank_one_motion(const Displacements& take, double hold_share);

/// The displacement at rest, 3 x M: medians over both ends of the recording, which begins and ends at rest. Zero where
/// it was held throughout. At least one frame.
Eigen::Matrix3Xd rest_of(const Displacements& take);

/// Markers that hardly move tell mostly noise: their displacement shrinks by what noise alone would have given
/// (James & Stein).
void shrink_to_evidence(RankOneMotion& motion);

}  // namespace risorius
