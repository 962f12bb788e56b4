// The time step between successive frames, made safe: a tracker's clock may stand still, run back or leap.
#pragma once

#include <algorithm>
#include <cstdint>

namespace risorius {

/// A backward or repeated time gives the last good step again; a leap gives at most kLongestStepS.
class FrameClock {
 public:
  static constexpr double kShortestStepS = 1e-4;
  static constexpr double kLongestStepS = 3600.0;

  /// `rate_hz` 0 = not stated: 60 Hz is assumed for the first step.
  void reset(double rate_hz) noexcept {
    started_ = false;
    step_s_ = rate_hz > 0 ? std::clamp(1.0 / rate_hz, kShortestStepS, kLongestStepS) : 1.0 / 60.0;
  }
  /// Seconds since the last frame, within [kShortestStepS, kLongestStepS].
  double advance(std::int64_t capture_time_ns) noexcept {
    if (started_ && capture_time_ns > last_ns_) {
      step_s_ = std::clamp((static_cast<double>(capture_time_ns) - static_cast<double>(last_ns_)) * 1e-9,
                           kShortestStepS, kLongestStepS);
    }
    started_ = true;
    last_ns_ = capture_time_ns;
    return step_s_;
  }

 private:
  bool started_ = false;
  std::int64_t last_ns_ = 0;
  double step_s_ = 1.0 / 60.0;
};

}  // namespace risorius
