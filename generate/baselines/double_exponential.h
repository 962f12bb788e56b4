// Continuation by double exponential smoothing (Brown 1956; as a predictor: LaViola 2003):
//
//   s1 += a (x - s1),  s2 += a (s1 - s2),  a = 1 - exp(-dt / tau)
//   x(t + h) = 2 s1 - s2 + h / dt  a / (1 - a) (s1 - s2)
//
// The named baseline `double_exponential`.
#pragma once

#include "generate/baselines/continuation_baseline.h"

namespace risorius {

struct DoubleExponentialOptions {
  double time_constant_ms = 50;  ///< [1, 10000]: tau
};

class DoubleExponential final : public ContinuationBaseline {
 public:
  /// Throws std::invalid_argument.
  explicit DoubleExponential(std::vector<double> upper_bound, const DoubleExponentialOptions& options = {});
  std::string_view name() const noexcept override { return "double_exponential"; }

 private:
  struct Smoothed {
    double once = 0, twice = 0, slope_per_s = 0;
  };
  void follow(std::size_t au, double value, double since_s) noexcept override;
  double predicted(std::size_t au, double ahead_s) const noexcept override;

  double time_constant_s_;
  std::vector<Smoothed> smoothed_;
};

}  // namespace risorius
