// A histogram of durations with 1/16-octave buckets (4.4 % wide) from 1 us to 67 s. One writer, any reader; fixed size.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "capture/counters.h"

namespace risorius {

class LatencyHistogram {
 public:
  void add(std::int64_t duration_ns) noexcept {
    const double us = std::max(1.0, static_cast<double>(duration_ns) * 1e-3);
    const auto bucket = static_cast<std::size_t>(std::min(std::log2(us) * kPerOctave, kBuckets - 1.0));
    buckets_[bucket].add();
    count_.add();
    max_ns_.raise_to(static_cast<std::uint64_t>(std::max<std::int64_t>(0, duration_ns)));
  }

  /// The duration in microseconds that a share `quantile` of the samples does not exceed (bucket's upper edge); 0 if
  /// empty.
  double quantile_us(double quantile) const noexcept {
    const double wanted = quantile * static_cast<double>(count_.value());
    double seen = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      seen += static_cast<double>(buckets_[i].value());
      if (seen >= wanted && seen > 0) {
        return std::min(std::exp2(static_cast<double>(i + 1) / kPerOctave),
                        static_cast<double>(max_ns_.value()) * 1e-3);
      }
    }
    return 0;
  }
  std::uint64_t count() const noexcept { return count_.value(); }
  double max_us() const noexcept { return static_cast<double>(max_ns_.value()) * 1e-3; }

 private:
  static constexpr double kPerOctave = 16;
  static constexpr double kBuckets = 26 * kPerOctave;
  std::array<Counter, static_cast<std::size_t>(kBuckets)> buckets_;
  Counter count_, max_ns_;
};

}  // namespace risorius
