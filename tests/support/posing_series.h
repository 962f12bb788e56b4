// An AU series of a face that goes from pose to pose and rests in each: what transitions can be cut out of.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "replay/performer/random.h"
#include "replay/takes/au_series.h"

namespace risorius::test {

inline constexpr double kPosingRateHz = 60;

/// `poses` random ones of five AUs and one that no face shows, and the rest before and after them; minimum jerk of 0.6
/// to 1.2 s between them, held for 0.5 s.
inline AuSeries posing_series(std::size_t poses, std::uint64_t seed) {
  AuSeries series{{"AU1", "AU4L", "AU12L", "AU12R", "AU27", "mouthLeft"}, {}, {}};
  Random random(seed, 0);
  std::vector<double> from(series.names.size(), 0), to = from;
  const auto add = [&](const std::vector<double>& row) {
    series.frames.push_back(series.frames.size());
    series.intensities.push_back(row);
  };
  for (std::size_t pose = 0; pose <= poses + 1; ++pose) {
    for (double& value : to) value = pose == 0 || pose > poses ? 0.0 : random.uniform(0, 0.9);
    const double seconds = random.uniform(0.6, 1.2);
    const int moving = static_cast<int>(seconds * kPosingRateHz), held = static_cast<int>(0.5 * kPosingRateHz);
    for (int frame = 1; frame <= moving + held; ++frame) {
      const double u = std::min(1.0, static_cast<double>(frame) / moving), m = u * u * u * (10 - 15 * u + 6 * u * u);
      std::vector<double> row = to;
      for (std::size_t k = 0; k < row.size(); ++k) row[k] = from[k] + m * (to[k] - from[k]);
      add(row);
    }
    from = to;
  }
  return series;
}

}  // namespace risorius::test
