#include "capture/repair/offline_repair.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/repair/baselines/interpolation.h"
#include "capture/repair/take_regression.h"
#include "capture/repair/take_rehearsal.h"

namespace risorius {
namespace {

/// Gaps of a take that are rehearsed, at most, and in how many places: about kRehearsals in all.
constexpr std::size_t kRehearsedGaps = 400, kRehearsals = 100, kFewestPlaces = 2, kMostPlaces = 8;

void check(const std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  if (options.max_gap_ns <= 0) {
    throw UserError("max_gap_ns", fmt::format("{} is not > 0", options.max_gap_ns),
                    "10000000000 (10 s) is the default");
  }
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}", set.id), problems.front(), "correct the take's marker set");
  }
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].count == set.names.size()) continue;
    throw UserError(fmt::format("frame {}", f),
                    fmt::format("it has {} markers, the set has {}", frames[f].count, set.names.size()),
                    "split the take where its marker set changes");
  }
}

void reject_not_finite(std::vector<MarkerFrame>& frames) noexcept {
  for (MarkerFrame& frame : frames) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      const Position p = frame.position_mm[i];
      if (frame.state[i] != MarkerState::kMeasured) continue;
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
      frame.state[i] = MarkerState::kRejected;
      frame.reason[i] = RejectReason::kNotFinite;
    }
  }
}

std::vector<Gap> gaps_of(const HeadTake& take, const std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns) {
  std::vector<Gap> gaps;
  for (std::size_t i = 0; i < take.markers; ++i) {
    for (std::size_t begin = 0, end = 0; begin < take.frames; begin = end + 1) {
      end = begin;
      while (end < take.frames && !take.measured[take.at(end, i)]) ++end;
      if (end == begin || end - begin == take.frames) continue;
      const std::size_t from = begin == 0 ? 0 : begin - 1, to = std::min(end, take.frames - 1);
      if (frames[to].header.capture_time_ns - frames[from].header.capture_time_ns <= max_gap_ns) {
        gaps.push_back({i, begin, end});
      }
    }
  }
  return gaps;
}

void fill_by_regression(std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  const HeadTake take = carry_into_head_frame(frames, set, options.head_frame);
  if (!take.has_pose) return;
  const std::vector<Gap> gaps = gaps_of(take, frames, options.max_gap_ns);
  if (gaps.empty()) return;
  const TakeRegression regression(take, set.names, options.known_motion);
  TakeRehearsal rehearsal(take, regression);
  const std::size_t each = (gaps.size() + kRehearsedGaps - 1) / kRehearsedGaps;
  const std::size_t places = std::clamp(kRehearsals / gaps.size(), kFewestPlaces, kMostPlaces);
  std::vector<GapRegression::Fill> fills;
  for (std::size_t g = 0; g < gaps.size(); ++g) {
    TakeRegression::Way way = regression.fill(gaps[g]);
    if (g % each == 0) rehearsal.practise(gaps[g], way.choice, places);
    fills.push_back(std::move(way.fill));
    if (options.progress) options.progress(static_cast<double>(g) / static_cast<double>(gaps.size()));
  }
  rehearsal.conclude();
  for (std::size_t g = 0; g < gaps.size(); ++g) {
    const auto [i, begin, end] = gaps[g];
    rehearsal.weigh(gaps[g], fills[g]);
    for (std::size_t f = begin; f < end; ++f) {
      const auto column = static_cast<Eigen::Index>(f - begin);
      take.set_filled(frames[f], f, i, fills[g].position_mm.col(column), std::sqrt(fills[g].variance_mm2[column]));
    }
  }
}

}  // namespace

void fill_offline(std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  check(frames, set, options);
  if (options.method != OfflineFillMethod::kNone) reject_not_finite(frames);
  if (options.method == OfflineFillMethod::kLinear) fill_linear(frames, options.max_gap_ns);
  if (options.method == OfflineFillMethod::kRegression && !frames.empty()) fill_by_regression(frames, set, options);
  if (options.progress) options.progress(1);
}

}  // namespace risorius
