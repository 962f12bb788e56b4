// Burke & Lasenby 2016, "Estimating missing marker positions using low dimensional Kalman smoothing" (J. Biomechanics
// 49), written from the paper: the markers move in a subspace of few dimensions, found in the frames that show all of
// them; a random walk in it is smoothed over the take. Offline.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"

namespace risorius {

struct KalmanFillOptions {
  double kept_energy = 0.99;  ///< of the complete frames, by the subspace
};

/// World coordinates. Where fewer than ten frames show all markers, straight.
void fill_kalman(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns, const KalmanFillOptions& options = {});

}  // namespace risorius
