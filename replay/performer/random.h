// Random numbers that are the same on every standard library: mt19937_64 is specified to the bit, the distributions of
// <random> are not, so they are written out here.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "replay/performer/ziggurat.h"

namespace risorius {

class Random {
 public:
  /// Streams of one seed are independent of each other: what is drawn from one does not change another.
  Random(std::uint64_t seed, std::uint64_t stream) : engine_(mixed(seed + mixed(stream))) {}

  /// [0, 1).
  double uniform() noexcept { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }
  bool chance(double probability) noexcept { return uniform() < probability; }
  /// 0 to count - 1; count > 0 and far below 2^53.
  std::size_t index(std::size_t count) noexcept {
    return static_cast<std::size_t>(uniform() * static_cast<double>(count));
  }
  double exponential(double mean) noexcept { return -mean * std::log1p(-uniform()); }
  /// Mean 0, variance 1. The polar method (Marsaglia & Bray 1964) makes two at a time; one waits for the next call.
  double gaussian() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double x = 0, y = 0, squared = 0;
    do {
      x = uniform(-1, 1);
      y = uniform(-1, 1);
      squared = x * x + y * y;
    } while (squared >= 1 || squared == 0);
    const double scale = std::sqrt(-2 * std::log(squared) / squared);
    spare_ = y * scale;
    has_spare_ = true;
    return x * scale;
  }
  /// The same distribution at a fifth of the time, for noise.
  double noise() noexcept {
    return Ziggurat::tables().draw([this] { return engine_(); }, [this] { return uniform(); });
  }

 private:
  /// SplitMix64 (Steele, Lea & Flood 2014), so that near seeds give unlike engines.
  static constexpr std::uint64_t mixed(std::uint64_t x) noexcept {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace risorius
