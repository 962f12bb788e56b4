// How often a stream may change its marker set: changing one costs the pipeline far more than a frame, and all streams
// share the pipeline. Many at once, then two a second: more than any tracker needs, and nothing that others would feel.
#pragma once

#include <algorithm>
#include <cstdint>

namespace risorius {

class SetChangeAllowance {
 public:
  static constexpr int kAtOnce = 16;
  static constexpr std::int64_t kPeriodNs = 500'000'000;

  /// Whether there is one left at this time, which is then taken. Times do not go back.
  bool take(std::int64_t now_ns) noexcept {
    const std::int64_t begun = now_ns - kAtOnce * kPeriodNs;
    spent_until_ns_ = any_ ? std::max(spent_until_ns_, begun) : begun;
    any_ = true;
    if (spent_until_ns_ + kPeriodNs > now_ns) return false;
    spent_until_ns_ += kPeriodNs;
    return true;
  }

 private:
  std::int64_t spent_until_ns_ = 0;  ///< each change spends a period
  bool any_ = false;
};

}  // namespace risorius
