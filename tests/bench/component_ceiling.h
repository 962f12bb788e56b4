// The ceiling for left-out markers: as many principal components as a rig has AUs, learned on frames of the same take
// and asked the same question (probabilistic PCA, Tipping & Bishop 1999). It knows nothing of faces, and its components
// mean nothing. Number of components (up to that of AUs) and noise are those that do best on the scored frames, which
// favours the ceiling.
#pragma once

#include <vector>

#include "solve/rigs/left_out_markers.h"

namespace risorius::bench {

/// 20 draws of 8 markers each, 2 of each quarter of the face by height; stabilisers stay. Empty
/// where there are fewer than 16 to choose from.
std::vector<std::vector<std::size_t>> hidden_draws(const Rig& rig);

/// Learns from frames with all markers; nothing explained if there are none. Poses and displacements are those of
/// `rig`; the components get the pose of all markers, also where some are hidden.
LeftOutEnergy component_ceiling(const Rig& rig, const TakeFrames& learned, const TakeFrames& scored,
                                const std::vector<std::vector<std::size_t>>& hidden_groups, std::size_t components);

}  // namespace risorius::bench
