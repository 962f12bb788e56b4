// A plain causal filler from the other markers: the mean and covariance of all frames so far, in the head's frame;
// their leading components, renewed every half second; a hidden marker is where the components that fit the visible
// markers say. Kept to be measured against.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {

struct OnlinePcaOptions {
  int components = 10;
  int renew_every_frames = 30;
};

/// Fills until a gap is longer than max_gap_ns. Frames in order of time; none looks ahead.
void fill_online_pca(std::vector<MarkerFrame>& frames, const MarkerSet& set, std::int64_t max_gap_ns,
                     const OnlinePcaOptions& options = {});

}  // namespace risorius
