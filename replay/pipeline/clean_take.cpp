#include "replay/pipeline/clean_take.h"

#include <algorithm>

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/repair/fill_methods.h"
#include "capture/repair/head_take.h"
#include "capture/repair/offline_repair.h"
#include "capture/repair/position_vector.h"

namespace risorius {
namespace {

constexpr std::uint64_t kProgressStride = 256;

void refuse_contradictions(const CleanOptions& options) {
  if (options.lookahead_frames > 0 && !options.is_causal) {
    throw UserError("--lookahead", "is of the causal filler; offline everything is looked at anyway", "add --causal");
  }
  if (!options.baseline.empty() && options.is_causal) {
    throw UserError("--baseline", "is itself causal or not", "leave out --causal");
  }
}

/// Despikes, and fills as the live service does where `filler` is given, frame by frame.
void read_repaired(TakeReader& take, GapFiller* filler, CleanedTake& cleaned,
                   const std::function<void(double)>& progress) {
  Despiker despiker;
  despiker.use_marker_set(take.info().markers);
  const std::uint64_t all = take.info().frame_count.value_or(0);
  MarkerFrame frame;
  while (take.next(frame)) {
    cleaned.before.push_back(frame);
    RISORIUS_CHECK(despiker.push(frame) && despiker.pop(frame));
    if (filler == nullptr) {
      cleaned.after.push_back(frame);
    } else {
      RISORIUS_CHECK(filler->push(frame, despiker));
      while (filler->pop(frame)) cleaned.after.push_back(frame);
    }
    if (progress && all > 0 && cleaned.before.size() % kProgressStride == 0) {
      progress((filler == nullptr ? 0.5 : 1.0) * static_cast<double>(cleaned.before.size()) / static_cast<double>(all));
    }
  }
  if (filler == nullptr) return;
  filler->flush();
  while (filler->pop(frame)) cleaned.after.push_back(frame);
}

void clean_live(TakeReader& take, const CleanOptions& options, CleanedTake& cleaned,
                const std::function<void(double)>& progress) {
  GapFillerOptions live{.lookahead_frames = options.lookahead_frames, .known_motion = options.known_motion};
  if (options.max_gap_ns > 0) live.max_gap_ns = options.max_gap_ns;
  GapFiller filler(live);
  filler.use_marker_set(take.info().markers);
  read_repaired(take, &filler, cleaned, progress);
}

void clean_offline(TakeReader& take, const CleanOptions& options, CleanedTake& cleaned,
                   const std::function<void(double)>& progress) {
  read_repaired(take, nullptr, cleaned, progress);
  const MarkerSet& set = take.info().markers;
  OfflineFillOptions offline{.known_motion = options.known_motion};
  if (options.max_gap_ns > 0) offline.max_gap_ns = options.max_gap_ns;
  if (progress) offline.progress = [&](double share) { progress(0.5 + 0.5 * share); };
  if (options.baseline.empty()) {
    fill_offline(cleaned.after, set, offline);
  } else {
    fill_method_named(options.baseline).fill(cleaned.after, set, offline.max_gap_ns);
  }
}

void count(CleanedTake& cleaned) {
  for (std::size_t f = 0; f < cleaned.after.size(); ++f) {
    for (std::size_t i = 0; i < cleaned.after[f].count; ++i) {
      const MarkerState state = cleaned.after[f].state[i];
      cleaned.measured += state == MarkerState::kMeasured;
      cleaned.filled += state == MarkerState::kFilled;
      cleaned.left_missing += state == MarkerState::kMissing || state == MarkerState::kRejected;
      cleaned.missing += cleaned.before[f].state[i] == MarkerState::kMissing;
      ++cleaned.rejected[static_cast<std::size_t>(cleaned.after[f].reason[i])];
    }
  }
}

}  // namespace

CleanedTake clean_take(TakeReader& take, const CleanOptions& options, const std::function<void(double)>& progress) {
  refuse_contradictions(options);
  CleanedTake cleaned;
  (options.is_causal ? clean_live : clean_offline)(take, options, cleaned, progress);
  count(cleaned);
  return cleaned;
}

void hold_head_still(CleanedTake& cleaned, const MarkerSet& set) {
  const HeadTake heads = carry_into_head_frame(cleaned.after, set, {});
  for (std::size_t f = 0; f < cleaned.after.size(); ++f) {
    for (MarkerFrame* frame : {&cleaned.before[f], &cleaned.after[f]}) {
      for (std::size_t i = 0; i < frame->count; ++i) {
        Position& p = frame->position_mm[i];
        p = to_position(heads.head_from_world[f] * to_vector(p));
      }
    }
  }
}

std::vector<std::string> most_repaired(const CleanedTake& cleaned, const MarkerSet& set, std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> repaired(set.names.size());  // samples measured, index
  for (std::size_t i = 0; i < repaired.size(); ++i) repaired[i].second = i;
  for (const MarkerFrame& frame : cleaned.after) {
    for (std::size_t i = 0; i < frame.count; ++i) repaired[i].first += frame.state[i] == MarkerState::kMeasured;
  }
  std::erase_if(repaired, [](const auto& marker) { return marker.first == 0; });  // never seen: nothing to look at
  std::ranges::sort(repaired);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < std::min(count, repaired.size()); ++k) names.push_back(set.names[repaired[k].second]);
  return names;
}

const char* name_of(RejectReason reason) noexcept {
  constexpr std::array kNames{"none", "jump", "deviation", "neighbour distance", "ghost", "swap", "not finite"};
  return kNames[static_cast<std::size_t>(reason)];
}

}  // namespace risorius
