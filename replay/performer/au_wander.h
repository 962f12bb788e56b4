// What a face does about its course: micro-motion (fast, small) and drift of the rest (slow). Smooth noise: two equal
// low-passes in a row over white noise, so that velocity exists. Draws in frame order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "replay/performer/dynamics.h"
#include "replay/performer/random.h"

namespace risorius {

class AuWander {
 public:
  /// `strength` scales both; 0 is none.
  AuWander(std::size_t au_count, const Wander& micro_motion, const Wander& drift, double strength, double rate_hz,
           std::uint64_t seed);

  /// Adds the next frame's wandering, not below 0 and not above `upper`.
  void add_to(std::span<double> values, std::span<const double> upper) noexcept;
  void rewind() noexcept;

 private:
  struct Filter {
    double keep = 0, input = 0, scale = 0;
    std::vector<double> first, second;
    std::vector<double> from, to;  ///< values at the steps around this frame
    int stride = 1, phase = 0;     ///< frames per step: a slow wandering needs few numbers
    Filter(std::size_t count, const Wander& wander, double strength, double rate_hz);
    void advance(Random& random) noexcept;
    double value(std::size_t k) const noexcept {
      return from[k] + (to[k] - from[k]) * static_cast<double>(phase) / static_cast<double>(stride);
    }
    void clear() noexcept;
  };
  bool is_still_;
  std::uint64_t seed_;
  Filter micro_motion_, drift_;
  Random random_;
};

}  // namespace risorius
