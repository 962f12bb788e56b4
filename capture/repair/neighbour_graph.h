// The nearest markers of each marker on the resting face.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "capture/repair/marker_statistics.h"

namespace risorius {

class NeighbourGraph {
 public:
  static constexpr std::size_t kNeighbours = 4;
  struct Neighbours {
    std::array<std::uint16_t, kNeighbours> index{};
    std::size_t count = 0;  ///< <= kNeighbours, nearest first
    double nearest_mm = 0;  ///< distance of the first; 0 if there is none
  };

  void resize(std::size_t markers) { of_.assign(markers, {}); }
  /// From the mean positions of the markers that were seen.
  void renew(const MarkerStatistics& statistics) noexcept;
  const Neighbours& of(std::size_t i) const noexcept { return of_[i]; }

 private:
  std::vector<Neighbours> of_;
};

}  // namespace risorius
