#include "generate/baselines/double_exponential.h"

#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace risorius {

DoubleExponential::DoubleExponential(std::vector<double> upper_bound, const DoubleExponentialOptions& options)
    : ContinuationBaseline(std::move(upper_bound)),
      time_constant_s_(options.time_constant_ms * 1e-3),
      smoothed_(au_count()) {
  if (!(options.time_constant_ms >= 1 && options.time_constant_ms <= 10000)) {
    throw std::invalid_argument(
        fmt::format("DoubleExponentialOptions.time_constant_ms {} is not in [1, 10000]", options.time_constant_ms));
  }
}

void DoubleExponential::follow(std::size_t au, double value, double since_s) noexcept {
  Smoothed& s = smoothed_[au];
  if (since_s <= 0) {
    s = {value, value, 0};
    return;
  }
  const double kept = std::exp(-since_s / time_constant_s_);  // 1 - a
  s.once = value + kept * (s.once - value);
  s.twice = s.once + kept * (s.twice - s.once);
  s.slope_per_s = (1 - kept) / kept * (s.once - s.twice) / since_s;
}

double DoubleExponential::predicted(std::size_t au, double ahead_s) const noexcept {
  const Smoothed& s = smoothed_[au];
  return 2 * s.once - s.twice + ahead_s * s.slope_per_s;
}

}  // namespace risorius
