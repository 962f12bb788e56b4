// How good one generated transition is, beside the real one of the same start, target and duration. Intensities; "%" is
// of the full range 1.2, as in seed 003. x0 is the last past row, x1 the first generated one, xN the last.
#pragma once

#include <vector>

#include "generate/transition.h"
#include "replay/evaluation/conspicuousness.h"

namespace risorius {

/// An AU whose range over past and truth is above this moves.
inline constexpr double kMovingRange = 0.05;

/// What the first generated frame has in it that the past did not announce, as means over the AUs that are counted.
struct SeamJump {
  double value = 0;                ///< |x1 - x0 - v0 dt|
  double velocity_per_s = 0;       ///< |v1 - v0 - a0 dt|
  double acceleration_per_s2 = 0;  ///< |a1 - a0 - j0 dt|
};
/// v, a and j are differences of rows; a past of fewer than four rows is taken as still before. `counted`: per AU.
SeamJump seam_jump(const AuMatrix& past, const AuMatrix& next, double rate_hz, const std::vector<bool>& counted);

/// |x1 - x0| of each AU, in %: the jumps of seed 003's tables.
std::vector<double> start_jumps_percent(const AuMatrix& past, const AuMatrix& next);

struct TransitionScore {
  double mean_squared_error = 0, mean_absolute_error = 0;  ///< over frames and AUs
  std::vector<double> squared_error_by_au;                 ///< mean over frames
  SeamJump seam, truth_seam;                               ///< over moving AUs; 0 where none moves
  double mean_jump_percent = 0, truth_jump_percent = 0;    ///< mean over AUs of |x1 - x0|
  double largest_jump_percent = 0;
  double end_error_percent = 0;  ///< the largest |xN - target| over AUs
  double end_step_percent = 0;   ///< the largest |xN - x(N-1)| over AUs, above the truth's
  double reactivation_percent = 0;
  int values_out_of_bounds = 0;  ///< below 0 or above 1.2
  int moving_aus = 0;
  Conspicuousness conspicuousness;
};

/// `past` P x A, `truth` and `made` N x A; the target is the truth's last row. Throws std::invalid_argument for sizes
/// that do not fit.
TransitionScore score_transition(const AuMatrix& past, const AuMatrix& truth, const AuMatrix& made, double rate_hz);

}  // namespace risorius
