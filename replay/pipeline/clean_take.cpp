#include "replay/pipeline/clean_take.h"

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/repair/fill_methods.h"
#include "capture/repair/offline_repair.h"

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
void read_repaired(TakeReader& take, const CleanOptions& options, GapFiller* filler, CleanedTake& cleaned,
                   const std::function<void(double)>& progress) {
  Despiker despiker({.head_frame = options.head_frame});
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
  GapFillerOptions live{.lookahead_frames = options.lookahead_frames,
                        .head_frame = options.head_frame,
                        .known_motion = options.known_motion};
  if (options.max_gap_ns > 0) live.max_gap_ns = options.max_gap_ns;
  GapFiller filler(live);
  filler.use_marker_set(take.info().markers);
  read_repaired(take, options, &filler, cleaned, progress);
}

void clean_offline(TakeReader& take, const CleanOptions& options, CleanedTake& cleaned,
                   const std::function<void(double)>& progress) {
  read_repaired(take, options, nullptr, cleaned, progress);
  const MarkerSet& set = take.info().markers;
  OfflineFillOptions offline{.head_frame = options.head_frame, .known_motion = options.known_motion};
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

const char* name_of(RejectReason reason) noexcept {
  constexpr std::array kNames{"none", "jump", "deviation", "neighbour distance", "ghost", "swap", "not finite"};
  return kNames[static_cast<std::size_t>(reason)];
}

}  // namespace risorius
