// What can be the place of a marker: a number, and not farther away than any room reaches.
#pragma once

#include <cmath>

namespace risorius {

/// Of a coordinate. What is farther away is an error of unit or a broken tracker, and would swamp every sum.
inline constexpr double kFarthestMm = 1e6;

inline bool is_plausible_position(float x_mm, float y_mm, float z_mm) noexcept {
  // False for what is no number, too.
  return std::abs(x_mm) <= kFarthestMm && std::abs(y_mm) <= kFarthestMm && std::abs(z_mm) <= kFarthestMm;
}

}  // namespace risorius
