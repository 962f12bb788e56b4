// A take repaired and nothing else: despiked, then filled offline, causally, or by a baseline.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture/repair/despiker.h"
#include "capture/repair/gap_filler.h"
#include "replay/takes/take.h"

namespace risorius {

struct CleanOptions {
  bool is_causal = false;                           ///< what the live service does
  std::uint32_t lookahead_frames = 0;               ///< causal only
  std::string baseline;                             ///< a name of capture/repair/fill_methods.h; empty: the default
  std::int64_t max_gap_ns = 0;                      ///< 0: the filler's own default
  std::shared_ptr<const KnownMotion> known_motion;  ///< such as a rig's
};

struct CleanedTake {
  std::vector<MarkerFrame> before, after;
  std::uint64_t measured = 0, missing = 0, filled = 0, left_missing = 0;  ///< samples
  std::array<std::uint64_t, 7> rejected{};                                ///< samples, by RejectReason
};

/// Holds the take in memory. `progress`: share done, now and then. Throws UserError for options that contradict each
/// other, or a take that cannot be read.
CleanedTake clean_take(TakeReader& take, const CleanOptions& options, const std::function<void(double)>& progress = {});

/// Before and after, with the head held still. Where the markers leave a pose open it is bridged.
void hold_head_still(CleanedTake& cleaned, const MarkerSet& set);

/// The names of the `count` markers, of those that were seen, of which most was filled or left missing; most first.
std::vector<std::string> most_repaired(const CleanedTake& cleaned, const MarkerSet& set, std::size_t count);

/// "jump", "deviation", ...
const char* name_of(RejectReason reason) noexcept;

}  // namespace risorius
