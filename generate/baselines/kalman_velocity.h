// Continuation by a Kalman filter of constant velocity per AU (white acceleration noise): x(t + h) = x + v h.
// The named baseline `kalman`.
#pragma once

#include "generate/baselines/continuation_baseline.h"

namespace risorius {

struct KalmanVelocityOptions {
  double noise = 0.02;            ///< [1e-5, 1]: standard deviation of a measured intensity
  double acceleration_noise = 1;  ///< [1e-4, 1e6]: spectral density of the acceleration, per s^3
};

class KalmanVelocity final : public ContinuationBaseline {
 public:
  /// Throws std::invalid_argument.
  explicit KalmanVelocity(std::vector<double> upper_bound, const KalmanVelocityOptions& options = {});
  std::string_view name() const noexcept override { return "kalman"; }

 private:
  /// Mean and covariance of value and velocity.
  struct State {
    double x = 0, v = 0, xx = 0, xv = 0, vv = 0;
  };
  void follow(std::size_t au, double value, double since_s) noexcept override;
  double predicted(std::size_t au, double ahead_s) const noexcept override;

  KalmanVelocityOptions options_;
  std::vector<State> states_;
};

}  // namespace risorius
