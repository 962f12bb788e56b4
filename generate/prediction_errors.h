// What a continuation's past errors say of its next ones: a standard deviation per AU and horizon, learnt online and
// causally, since a prediction counts only once its time has passed.
//
//   s^2 = (n0 s0(h)^2 + sum_k f_k err_k^2) / (n0 + sum_k f_k),   f_k = exp(-age_k / memory),  n0 = 10
//   s0(h) = min(0.3, h / 1 s)
//
// Nothing allocates after construction. One thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "capture/frames.h"

namespace risorius {

class PredictionErrors {
 public:
  /// 1 to kMaxAus AUs; `memory_s` in [0.1, 1000]. Throws std::invalid_argument.
  PredictionErrors(std::size_t aus, double memory_s);

  /// The next frame's intensities, as many as AUs, NaN where not observed: scores what was predicted for the time
  /// since the last one, unless that is a hole.
  void observe(std::int64_t time_ns, std::span<const float> intensity) noexcept;
  /// What was predicted from the frame observed last. Other horizons than the last time's begin anew.
  void remember(const Continuation& continuation) noexcept;
  /// Of the step-th horizon of the continuation remembered last.
  float deviation(std::size_t step, std::size_t au) const noexcept;
  /// Sets the horizons that remember() will bring, so that deviation() can be asked before it.
  void use_horizons(std::span<const std::int64_t> ahead_ns) noexcept;
  /// Forgets frames and predictions, not what was learnt: errors belong to the actor, motion to the take.
  void reset() noexcept;

 private:
  struct Error {
    double squared_sum = 0, weight = 0;
  };
  static constexpr std::size_t kRemembered = 256;  // 2 s, the longest horizon, at 125 frames/s

  std::size_t slot_before(std::size_t back) const noexcept { return (next_ + kRemembered - 1 - back) % kRemembered; }
  std::span<float> prediction(std::size_t slot, std::size_t step) noexcept {
    return {predictions_.data() + (slot * kMaxContinuationSteps + step) * aus_, aus_};
  }
  void learn_step(std::size_t step, std::int64_t time_ns, std::span<const float> intensity) noexcept;

  std::size_t aus_;
  double memory_s_;
  std::vector<std::int64_t> made_ns_;  // kRemembered, a ring
  std::vector<float> predictions_;     // kRemembered x kMaxContinuationSteps x aus
  std::size_t next_ = 0, count_ = 0;
  bool has_last_ = false;
  std::int64_t last_ns_ = 0;
  std::vector<float> last_;
  std::size_t step_count_ = 0;
  std::array<std::int64_t, kMaxContinuationSteps> ahead_ns_{};
  std::vector<Error> errors_;  // kMaxContinuationSteps x aus
};

}  // namespace risorius
