// How long a datagram socket is left alone after a full turn that brought only what is of no use: a flood of garbage
// must not take the thread from the other sources. What the socket's buffer cannot hold meanwhile the kernel counts.
#pragma once

#include <algorithm>
#include <chrono>

namespace risorius {

class FloodRest {
 public:
  /// After a full turn. Zero if it was of use; else twice as long as the last time.
  std::chrono::microseconds after_turn(bool was_useless) noexcept {
    rest_ = was_useless ? std::clamp(2 * rest_, kFirst, kLongest) : std::chrono::microseconds{};
    return rest_;
  }

  static constexpr std::chrono::microseconds kFirst{250};
  /// At most 128 datagrams in this time: a twentieth of the thread, and a full buffer of garbage is read in a second.
  static constexpr std::chrono::microseconds kLongest{4000};

 private:
  std::chrono::microseconds rest_{};
};

}  // namespace risorius
