// How well a rig predicts markers that the solve has not seen, on a real take: some are hidden over the whole take, the
// others are solved, and the share of the hidden ones' motion about the neutral (in the head's frame) that the solved
// face explains is pooled over draws. Beside it what as many principal components, fitted on the first half of the same
// take, explain by the same protocol. Both are scored on the second half.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "solve/rigs/rig.h"

namespace risorius::bench {

struct LeftOutEnergy {
  double by_rig = 0, by_components = 0;  ///< shares
  int components = 0;
};

/// `hidden` markers per draw, one from each band of the face's height.
LeftOutEnergy left_out_energy(const Rig& rig, const MarkerSet& markers, const std::vector<MarkerFrame>& frames,
                              int hidden, int draws, std::uint64_t seed);

}  // namespace risorius::bench
