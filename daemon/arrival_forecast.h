// When the next frame of a stream is due, from the rhythm of those before it.
//
// A processor that sleeps between frames wakes in some 50 us for each thread on the frame's way, and works slowly at
// first. Threads that are awake when the frame comes save that; how long they may be awake for nothing is bounded by a
// share of the frame time. A stream whose rhythm is looser than that share is slept through as before. One thread; the
// counters are read from any.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "capture/counters.h"

namespace risorius {

class ArrivalForecast {
 public:
  struct Window {
    std::int64_t from_ns = 0, until_ns = 0;
  };

  /// `awake_share`: of a frame time, that a window may take at most; 0 = none is ever given.
  explicit ArrivalForecast(double awake_share) : awake_share_(awake_share) {}

  void frame_came(std::int64_t receive_ns) noexcept {
    if (awake_share_ <= 0) return;
    if (window_) (receive_ns >= window_->from_ns && receive_ns <= window_->until_ns ? foreseen_ : missed_).add();
    learn(receive_ns);
    window_ = forecast();
  }
  /// The stream has ended, or another one begins.
  void reset() noexcept {
    frames_ = off_rhythm_ = 0;
    window_.reset();
  }

  /// In which to be awake for the next frame; none while the rhythm is unknown or too loose.
  const std::optional<Window>& window() const noexcept { return window_; }

  /// Frames that came within their window, and such that came before or after it; those without a window are neither.
  const Counter& foreseen() const noexcept { return foreseen_; }
  const Counter& missed() const noexcept { return missed_; }

 private:
  static constexpr int kFramesToLearn = 16;
  /// A frame that does not come when the last one said adds 2, one that does takes 1 away; beyond, it is another
  /// rhythm.
  static constexpr int kMostOffRhythm = 32;
  static constexpr std::int64_t kMostLost = 8;
  static constexpr double kLoosest = 0.1;  ///< mean absolute deviation, in periods
  // Of a loop that follows the phase and the period of the arrivals.
  static constexpr double kPhaseGain = 0.1, kPeriodGain = 0.005, kDeviationGain = 1.0 / 32;
  static constexpr double kWakingNs = 80e3;    ///< of the I/O thread, and of the pipeline's, which it wakes
  static constexpr double kSlackNs = 20e3;     ///< beyond the deviation, at the end
  static constexpr double kDeviations = 2;     ///< mean absolute ones, at both ends
  static constexpr double kLongestNs = 300e3;  ///< whatever the share
  static constexpr double kLeastPart = 0.6;    ///< of what the deviation asks for; with less, most frames are missed

  void learn(std::int64_t receive_ns) noexcept {
    if (frames_ < kFramesToLearn) return learn_period(receive_ns);
    const double surprise_ns = static_cast<double>(receive_ns - due_ns_);
    const double frames_lost = std::round(surprise_ns / period_ns_);
    const double error_ns = surprise_ns - frames_lost * period_ns_;
    const bool is_between = frames_lost < 0 || std::abs(error_ns) > 0.25 * period_ns_;
    // A silence, a lost frame, a burst, a frame between the beats: no other rhythm, unless it goes on.
    off_rhythm_ = is_between || frames_lost > 0 ? off_rhythm_ + 2 : std::max(0, off_rhythm_ - 1);
    if (off_rhythm_ > kMostOffRhythm) return reset();
    if (frames_lost > kMostLost) {  // after a silence the phase is another, the period is not
      due_ns_ = receive_ns + static_cast<std::int64_t>(period_ns_);
      return;
    }
    if (is_between) return;
    period_ns_ += kPeriodGain * error_ns;
    deviation_ns_ += kDeviationGain * (std::abs(error_ns) - deviation_ns_);
    due_ns_ += static_cast<std::int64_t>((frames_lost + 1) * period_ns_ + kPhaseGain * error_ns);
    // A rate near 4:5 or 5:6 of the old one falls in with it now and then, so that nothing is off "in a row".
    if (deviation_ns_ > kLoosest * period_ns_) reset();
  }

  /// The mean of the first frame times, and their mean deviation from it, is where the loop begins.
  void learn_period(std::int64_t receive_ns) noexcept {
    arrivals_ns_[static_cast<std::size_t>(frames_++)] = receive_ns;
    if (frames_ < kFramesToLearn) return;
    period_ns_ = static_cast<double>(receive_ns - arrivals_ns_.front()) / (kFramesToLearn - 1);
    deviation_ns_ = 0;
    for (std::size_t i = 1; i < arrivals_ns_.size(); ++i) {
      deviation_ns_ +=
          std::abs(static_cast<double>(arrivals_ns_[i] - arrivals_ns_[i - 1]) - period_ns_) / (kFramesToLearn - 1);
    }
    due_ns_ = receive_ns + static_cast<std::int64_t>(period_ns_);
    // A frame was lost, or there is no rhythm, or a faster one than is ever waited for.
    if (period_ns_ < kWakingNs || deviation_ns_ > kLoosest * period_ns_) reset();
  }

  /// Where the deviation asks for more than the share, as much of it as the share allows.
  std::optional<Window> forecast() const noexcept {
    if (frames_ < kFramesToLearn) return std::nullopt;
    const double before_ns = kWakingNs + kDeviations * deviation_ns_, after_ns = kSlackNs + kDeviations * deviation_ns_;
    const double part = std::min(kLongestNs, awake_share_ * period_ns_) / (before_ns + after_ns);
    if (part < kLeastPart) return std::nullopt;
    const auto from = static_cast<std::int64_t>(std::min(1.0, part) * before_ns);
    const auto until = static_cast<std::int64_t>(std::min(1.0, part) * after_ns);
    return Window{due_ns_ - from, due_ns_ + until};
  }

  double awake_share_;
  int frames_ = 0, off_rhythm_ = 0;
  std::array<std::int64_t, kFramesToLearn> arrivals_ns_{};  ///< the first ones
  std::int64_t due_ns_ = 0;                                 ///< the next frame
  double period_ns_ = 0, deviation_ns_ = 0;
  std::optional<Window> window_;
  Counter foreseen_, missed_;
};

}  // namespace risorius
