// Calibrates a rig as seed 003 does: from a neutral and one recording per AU at its maximum. Recordings are imperfect:
// the head moves, the actor goes there and back, blinks, markers vanish or lie. Each recording is explained as
//     head_from_world p_tm = E0_m + b_m + a_t e_m
// (one time course a_t, one field e, a rest b), robustly, by alternating least squares; e is scaled to the held
// maximum. A rig fitted to the same neutral gives neutral, stabilisers and the expectation against which each recording
// is checked: does it move, on the right side, and more like its own AU than like another?
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

struct CalibrationRecording {
  std::string au;                          ///< the column's name, such as "AU12L"
  std::string place;                       ///< take and range, for messages
  std::vector<Eigen::Matrix3Xd> world_mm;  ///< per frame 3 x M in the fitted rig's marker order; NaN: not measured
};

struct RigCalibrateOptions {
  double least_peak_mm = 0.5;  ///< a recording whose farthest marker moves less does not show its AU, > 0
  double least_match = 0.4;    ///< cosine to the expected field below which a recording is doubted, [-1, 1]
  double alike_cosine = 0.95;  ///< two AUs whose fields are more alike cannot be told apart, (0, 1]
  double hold_share = 0.9;     ///< of the greatest amplitude that counts as held, (0, 1)
};

/// What one recording gave.
struct AuCalibration {
  std::string au;
  std::size_t frames = 0, held_frames = 0;
  std::string peak_marker;
  double peak_mm = 0;      ///< how far that marker moves
  double noise_mm = 0;     ///< what the explanation leaves, per axis
  double rest_mm = 0;      ///< how far the recording's rest lies from the neutral, rms over markers
  double left_share = 0;   ///< of the energy, on markers of the subject's left; the midline counts half
  double match = 0;        ///< cosine to the expected field; NaN where the fitted rig has no such AU
  std::string best_match;  ///< the AU of the fitted rig that the recording resembles most
  double best_match_cosine = 0;
};

struct RigCalibration {
  Rig rig;  ///< the recorded AUs only, in the order given
  std::vector<AuCalibration> aus;
  double condition = 0;               ///< of the Gram matrix of the normalised fields
  std::vector<std::string> warnings;  ///< one sentence each: wrong side, another AU, AUs alike, rests that drift
};

/// Throws UserError naming the recording and what to do where it does not show its AU, has too few frames in which the
/// head can be found, or where an AU is given twice.
RigCalibration calibrate_rig(const Rig& fitted, const std::vector<CalibrationRecording>& recordings,
                             const RigCalibrateOptions& options = {});

}  // namespace risorius
