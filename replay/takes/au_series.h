// A recorded series of named channels (AUs, or ARKit's shapes), one row of values per frame, and what a channel of
// another name can be served by.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

/// What an intensity in a file can be; beyond, the column holds something else.
inline constexpr double kLeastIntensity = -0.2, kMostIntensity = 2;

struct AuSeries {
  std::vector<std::string> names;
  std::vector<std::uint64_t> frames;             ///< F, as the file counts; growing
  std::vector<std::vector<double>> intensities;  ///< F rows of names.size() values; NaN where not observed
};

/// The columns whose mean stands for the channel `wanted`: the one of that name; else, for a side ("AU1L"), the AU
/// without a side; else, for an AU without a side ("AU9"), its two sides. Empty where there is none.
std::vector<std::size_t> columns_for(const std::vector<std::string>& names, std::string_view wanted);

}  // namespace risorius
