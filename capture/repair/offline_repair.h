// Fills the gaps of a whole take, with past and future at hand. Measured samples are never changed.
// Default: each gap of each marker is a regression (capture/repair/gap_regression.h) in the head's frame, learnt from
// the samples around the gap and a few hundred from all over the take, on the markers that are seen in the gap.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/repair/head_frame.h"
#include "capture/repair/known_motion.h"

namespace risorius {

enum class OfflineFillMethod : std::uint8_t { kNone, kLinear, kRegression };

struct OfflineFillOptions {
  OfflineFillMethod method = OfflineFillMethod::kRegression;
  std::int64_t max_gap_ns = 10'000'000'000;  ///< a longer gap stays missing altogether, > 0
  HeadFrameOptions head_frame;
  std::shared_ptr<const KnownMotion> known_motion;  ///< such as a rig's; null: only the take
  std::function<void(double)> progress;             ///< called now and then with the share done, 0 to 1; may be empty
};

/// Fills missing and rejected markers (state kFilled, standard_deviation_mm set, reason kept). A marker that was never
/// measured stays missing. kRegression also fills at the ends of the take, and where the head pose is open (a
/// whole-frame drop-out), with the pose between its neighbours; a take that shows no head at all is left as it is.
/// Frames must be in order of capture time. Throws UserError for a bad option, a bad set, or a frame whose count is
/// not the set's.
void fill_offline(std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options);

}  // namespace risorius
