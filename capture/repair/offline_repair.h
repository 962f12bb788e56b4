// Fills the gaps of a whole take, with past and future at hand. Measured samples are never changed.
//
// Default: the low-rank statistics of the whole take predict a hidden marker, p(t), from the visible ones; across a gap
// from a to b the fill is   y(t) = line(y_a, y_b)(t) + beta (p(t) - line(p_a, p_b)(t)),
// which meets the measured samples at both ends. beta, between the straight line (0) and the prediction with its
// residual carried across (1), is the least-squares one, learnt on artificial gaps of the same length in the take
// itself, as is the error that is stated.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/repair/head_frame.h"
#include "capture/repair/marker_statistics.h"

namespace risorius {

enum class OfflineFillMethod : std::uint8_t { kNone, kLinear, kLowRank };

struct OfflineFillOptions {
  OfflineFillMethod method = OfflineFillMethod::kLowRank;
  std::int64_t max_gap_ns = 10'000'000'000;  ///< a longer gap stays missing altogether, > 0
  HeadFrameOptions head_frame;
  MarkerStatisticsOptions statistics{.memory_s = 1e6, .model_doubt = 16};
  std::function<void(double)> progress;  ///< called now and then with the share done, 0 to 1; may be empty
};

/// Fills missing and rejected markers (state kFilled, standard_deviation_mm set, reason kept). A marker that was never
/// measured stays missing. kLowRank also fills at the ends of the take, with the prediction and its fading residual;
/// frames without a determined head pose are left as they are.
/// Frames must be in order of capture time. Throws UserError for a bad option, a bad set, or a frame whose count is
/// not the set's.
void fill_offline(std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options);

}  // namespace risorius
