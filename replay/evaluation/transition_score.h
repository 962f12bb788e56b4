// How good one generated transition is, beside the real one of the same start, target and duration. Intensities; "%" is
// of the full range 1.2, as in seed 003. x0 is the last past row, x1 the first generated one, xN the last.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "generate/transition.h"

namespace risorius {

inline constexpr double kFullRange = 1.2;
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

/// How far an AU runs against the way from its start to its end, in %: max over i < j of s (x_i - x_j), s the sign of
/// xN - x0 (+1 if equal), i and j over start and course.
double reactivation_percent(double start, std::span<const float> course);

/// Seed 003's criteria for a conspicuous animation (its 6.3.1), as one formula:
///
///   conspicuous = E > 1  or  some J > 40 %  or  three J > 20 %  or  some R > 25 %  or  some S > 25 %
///
/// E: sum over frames of the mean over AUs of (made - truth)^2. Seed 003 says of its "absolute error" only that it
/// averages AUs; this reading agrees with its own figures (0.07 to 0.58 at a mean squared error of 0.0014). J per AU:
/// the largest |x_k - x_(k-1)|, start included. R per AU: reactivation above the truth's. S per AU: the larger one of
/// |x1 - x0| minus the truth's, and |xN - target|.
struct Conspicuousness {
  double summed_error = 0;          ///< E
  double largest_jump_percent = 0;  ///< of all J
  int jumps_above_20 = 0;           ///< AUs
  double reactivation_percent = 0;  ///< of all R
  double end_percent = 0;           ///< of all S
  bool is_conspicuous() const noexcept;
};

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
