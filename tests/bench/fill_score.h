// How well gaps were filled: errors against the take before the noise, steps at the ends, and how honest and sharp the
// stated deviations are.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"

namespace risorius::bench {

/// One filled sample. Bin: octave of the frames from the gap's start (causal) or from its nearer end (offline), in
/// which a method without deviations of its own is given one.
struct ErrorSample {
  float error_mm[3];
  float deviation_mm;
  std::uint8_t bin;
};

struct DrawScore {
  std::vector<ErrorSample> samples;
  std::vector<double> start_step_mm, end_step_mm;  ///< by gap: what the true motion does not explain
  std::size_t left_missing = 0;

  double sum_mm() const;
  double sum_squared_mm2() const;
};

/// `cut` is what was filled; samples that `clean` does not have are not scored.
DrawScore score_draw(const std::vector<MarkerFrame>& clean, const std::vector<MarkerFrame>& cut,
                     const std::vector<MarkerFrame>& filled, bool is_causal);

using MethodScore = std::vector<DrawScore>;  ///< by draw

double mean_mm(const MethodScore& score);
double rmse_mm(const MethodScore& score);
/// Share of the axis errors within the stated 90 % interval, in %.
double coverage_percent(const MethodScore& score);
/// Mean continuous ranked probability score per axis of N(filled, deviation), mm. `calibrated`: the deviation is not
/// the stated one but the root mean square error of the *other* draws in the same bin: better than any baseline could
/// know.
double crps_mm(const MethodScore& score, bool calibrated);
/// The 99th percentile over the gaps.
double start_step_p99_mm(const MethodScore& score);
double end_step_p99_mm(const MethodScore& score);

struct Interval {
  double low, high;
};
/// Of mean(a) / mean(b), 95 %, draws resampled in pairs (seeded).
Interval ratio_interval(const MethodScore& a, const MethodScore& b);

}  // namespace risorius::bench
