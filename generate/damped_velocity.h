// Continuation by the present velocity, dying away:  x(t + h) = clip(x + v tau (1 - exp(-h / tau)), 0, upper)
// with v the median of the slopes between the frames of the last window (Theil 1950; Sen 1968), which one bad frame
// cannot turn. Standard deviations are learnt online from its own past errors, per AU and horizon, causally: an error
// counts once the predicted time has passed. The named baseline `damped_velocity`.
#pragma once

#include <array>
#include <vector>

#include "generate/continuation.h"
#include "generate/prediction_errors.h"

namespace risorius {

struct DampedVelocityOptions {
  double window_ms = 50;         ///< [1, 1000]: frames this young give the velocity
  double time_constant_ms = 80;  ///< [1, 10000]: tau
  double memory_s = 10;          ///< [0.1, 1000]: over which errors are remembered
};

class DampedVelocity final : public ContinuationModel {
 public:
  /// `upper_bound` per AU, 1 to kMaxAus of them, in (0, 2]. Throws std::invalid_argument.
  explicit DampedVelocity(std::vector<double> upper_bound, const DampedVelocityOptions& options = {});

  std::string_view name() const noexcept override { return "damped_velocity"; }
  void observe(const AuFrame& frame) noexcept override;
  void predict(Continuation& continuation) noexcept override;
  void reset() noexcept override;

 private:
  /// What is kept of a frame.
  struct Moment {
    std::int64_t time_ns = 0;
    std::array<float, kMaxAus> x{};
    std::array<float, kMaxAus> velocity_per_s{};  // NaN where the AU was not observed
  };
  static constexpr std::size_t kMoments = 16;  // of the window; the youngest

  const Moment& past(std::size_t back) const noexcept { return moments_[(next_ + kMoments - 1 - back) % kMoments]; }
  float velocity_of(std::size_t au) noexcept;
  double predicted(const Moment& from, std::size_t au, double ahead_s) const noexcept;

  std::vector<double> upper_bound_;
  DampedVelocityOptions options_;
  std::vector<Moment> moments_;  // ring of kMoments
  std::size_t next_ = 0, count_ = 0;
  std::vector<float> slopes_, observed_;  // scratch
  PredictionErrors errors_;
};

}  // namespace risorius
