// Small smooth functions that the built-in face's surface and its AU fields are made of.
#pragma once

#include <algorithm>
#include <cmath>

namespace risorius {

/// 0 up to `from`, 1 from `to` on, with zero slope and curvature at both ends. `from` may be above `to`.
inline double smooth_between(double from, double to, double at) noexcept {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * t * (t * (6 * t - 15) + 10);
}

/// Wendland's function C2 of a distance in radii: 1 at 0, 0 with its first two derivatives from 1 on.
inline double compact_bell(double distance) noexcept {
  if (distance >= 1) return 0;
  const double rest = (1 - distance) * (1 - distance);
  return rest * rest * (4 * distance + 1);
}

/// exp(-1/2 d^2) of an elliptic distance.
inline double gauss(double u, double v = 0) noexcept { return std::exp(-0.5 * (u * u + v * v)); }

}  // namespace risorius
