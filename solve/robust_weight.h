// How much a point is trusted that lies `distance` from where it should: 1 up to the threshold, then (threshold /
// distance)^power. The influence distance * weight is constant for power 1 (Huber: convex), and falls to nothing for
// power 4. Raising the power step by step lets a convex problem choose the side before the far points are given up.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace risorius {

inline double robust_weight(double distance, double threshold, int power) noexcept {
  if (distance <= threshold) return 1;
  const double ratio = threshold / distance;
  double weight = ratio;
  for (int i = 1; i < power; ++i) weight *= ratio;
  return weight;
}

/// 1, 2, 4, 4, ... for iteration 0, 1, 2, 3, ...
inline int robust_power(int iteration) noexcept { return iteration < 2 ? 1 + iteration : 4; }

/// The lower median; reorders the values. 0 if there are none.
inline double lower_median(std::span<double> values) noexcept {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace risorius
