#include "capture/repair/neighbour_graph.h"

#include <algorithm>

namespace risorius {

void NeighbourGraph::renew(const MarkerStatistics& statistics) noexcept {
  for (std::size_t i = 0; i < of_.size(); ++i) {
    Neighbours& neighbours = of_[i];
    neighbours = {};
    if (!statistics.seen(i)) continue;
    std::array<double, kNeighbours> distance_mm{};
    for (std::size_t j = 0; j < of_.size(); ++j) {
      if (j == i || !statistics.seen(j)) continue;
      const double distance = (statistics.mean_mm(i) - statistics.mean_mm(j)).norm();
      std::size_t at = neighbours.count;
      while (at > 0 && distance_mm[at - 1] > distance) --at;
      if (at == kNeighbours) continue;
      neighbours.count = std::min(neighbours.count + 1, kNeighbours);
      for (std::size_t k = neighbours.count - 1; k > at; --k) {
        distance_mm[k] = distance_mm[k - 1];
        neighbours.index[k] = neighbours.index[k - 1];
      }
      distance_mm[at] = distance;
      neighbours.index[at] = static_cast<std::uint16_t>(j);
    }
    neighbours.nearest_mm = distance_mm[0];
  }
}

}  // namespace risorius
