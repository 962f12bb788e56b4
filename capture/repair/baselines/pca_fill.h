// Gloersen & Federolf 2016, "Predicting missing marker trajectories in human motion data using marker
// intercorrelations" (PLoS ONE 11(3), e0152616), strategy R2, written from the paper: a marker's gaps are predicted
// from the markers that are seen throughout them, by carrying the principal components of the frames without that
// marker over to those with it; markers count by their distance. Offline.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"

namespace risorius {

/// The paper's own values.
struct PcaFillOptions {
  double weight_scale_mm = 200;     ///< a marker counts exp(-distance^2 / (2 scale^2))
  double missing_weight = 0.02;     ///< the marker to predict itself counts so much
  double distal_threshold = 0.5;    ///< other markers with gaps help within this share of the mean distance only
  double kept_singular_sum = 0.99;  ///< so many components are kept that their singular values sum to this share
};

/// World coordinates. Where no frame shows what a marker needs, its gaps are filled straight.
void fill_pca(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns, const PcaFillOptions& options = {});

}  // namespace risorius
