// Gaps bridged from the samples at their ends, one marker at a time: straight in the world (the method of the seed 000
// paper), straight in the head's frame, and by the cubic through the two samples before and the two after (as the
// spline fill of optical systems does). Offline. A gap longer than max_gap_ns stays missing; so do the ends of a take.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {

/// World coordinates; the standard deviation is that of a random walk between the ends, with the take's own steps.
void fill_linear(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns);
/// The same in the head's frame.
void fill_linear_in_head(std::vector<MarkerFrame>& frames, const MarkerSet& set, std::int64_t max_gap_ns);
/// World coordinates. Where two samples in a row are missing beside the gap, straight.
void fill_cubic(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns);

}  // namespace risorius
