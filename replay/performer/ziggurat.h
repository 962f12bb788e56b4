// Normal numbers for noise, many per frame: the ziggurat of Marsaglia & Tsang (2000) with 256 layers, one draw of the
// engine for 99 of 100. The tables are computed, not quoted.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace risorius {

class Ziggurat {
 public:
  static const Ziggurat& tables() noexcept {
    static const Ziggurat ziggurat;
    return ziggurat;
  }

  /// Mean 0, variance 1. `engine` gives 64 random bits, `uniform` numbers of [0, 1).
  template <class Engine, class Uniform>
  double draw(Engine&& engine, Uniform&& uniform) const noexcept {
    while (true) {
      const std::uint64_t bits = engine();
      const std::size_t layer = bits & (kLayers - 1);
      const double sign = (bits & kLayers) != 0 ? -1 : 1;
      const double x = static_cast<double>(bits >> 11) * 0x1p-53 * x_[layer];
      if (x < x_[layer + 1]) return sign * x;  // inside the layer above: surely below the curve
      if (layer == 0) return sign * tail(uniform);
      const double y = y_[layer] + uniform() * (y_[layer + 1] - y_[layer]);
      if (y < std::exp(-0.5 * x * x)) return sign * x;
    }
  }

 private:
  static constexpr std::size_t kLayers = 256;
  static constexpr double kTail = 3.6541528853610088;  ///< where the lowest layer ends and the tail begins

  /// Layers of equal area v under exp(-x^2 / 2): layer 0 is the strip below the curve at kTail together with the tail.
  Ziggurat() noexcept {
    const double at_tail = std::exp(-0.5 * kTail * kTail);
    const double area = kTail * at_tail + std::sqrt(M_PI / 2) * std::erfc(kTail / std::sqrt(2.0));
    x_[0] = area / at_tail;  // as wide as a rectangle of that area would be
    y_[0] = 0;
    x_[1] = kTail;
    y_[1] = at_tail;
    for (std::size_t i = 2; i < kLayers; ++i) {
      y_[i] = y_[i - 1] + area / x_[i - 1];
      x_[i] = std::sqrt(-2 * std::log(y_[i]));
    }
    x_[kLayers] = 0;
    y_[kLayers] = 1;
  }

  /// Beyond kTail, by Marsaglia's exponential wedge.
  template <class Uniform>
  static double tail(Uniform&& uniform) noexcept {
    double x = 0, y = 0;
    do {
      x = -std::log1p(-uniform()) / kTail;
      y = -std::log1p(-uniform());
    } while (2 * y < x * x);
    return kTail + x;
  }

  std::array<double, kLayers + 1> x_{}, y_{};
};

}  // namespace risorius
