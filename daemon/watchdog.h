// Whether a stream that should be coming still comes: silent for three frame times, it is stale.
// The frame time is the longer one of what the marker set states and what was seen lately, so that a take played slowly
// is not taken for a dead tracker. One thread; the state is read from any.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "capture/counters.h"

namespace risorius {

class Watchdog {
 public:
  /// Nothing less is taken for silence: three frame times of a stream of 1000 Hz.
  static constexpr std::int64_t kShortestSilenceNs = 3'000'000;
  static constexpr int kFrameTimes = 3;

  void use_rate(double rate_hz) noexcept { stated_ns_ = rate_hz > 0 ? 1e9 / rate_hz : 0; }
  /// True if the stream was stale until now.
  bool frame_came(std::int64_t receive_ns) noexcept {
    // A silence is no frame time; but where nobody states one, a burst at the begin must not make every frame late.
    if (running_ && receive_ns > last_ns_ && (!stale() || stated_ns_ == 0)) {
      const double step_ns = std::min(static_cast<double>(receive_ns - last_ns_), kLongestFrameTimeNs);
      seen_ns_ = seen_ns_ == 0 ? step_ns : seen_ns_ + kSmoothing * (step_ns - seen_ns_);
    }
    running_ = true;
    last_ns_ = std::max(last_ns_, receive_ns);
    return stale_.exchange(false, std::memory_order_relaxed);
  }
  /// The stream ended as streams do: silence means nothing from here on.
  void stream_ended() noexcept {
    running_ = false;
    seen_ns_ = 0;
    stale_.store(false, std::memory_order_relaxed);
  }

  bool running() const noexcept { return running_; }
  /// When silence becomes staleness, if nothing comes; only while running.
  std::int64_t deadline_ns() const noexcept {
    const auto silence_ns = static_cast<std::int64_t>(kFrameTimes * std::max(stated_ns_, seen_ns_));
    return last_ns_ + std::max(kShortestSilenceNs, silence_ns);
  }
  /// True if the stream has just become stale.
  bool look(std::int64_t now_ns) noexcept {
    if (!running_ || stale() || now_ns < deadline_ns()) return false;
    stale_.store(true, std::memory_order_relaxed);
    silences_.add();
    return true;
  }

  bool stale() const noexcept { return stale_.load(std::memory_order_relaxed); }
  /// How often the stream went stale.
  const Counter& silences() const noexcept { return silences_; }

 private:
  static constexpr double kSmoothing = 0.1;
  static constexpr double kLongestFrameTimeNs = 1e9;
  bool running_ = false;
  double stated_ns_ = 0, seen_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::atomic<bool> stale_{false};
  Counter silences_;
};

}  // namespace risorius
