#include "replay/pipeline/rig_neutral.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/pipeline/neutral_candidates.h"
#include "replay/pipeline/offline_pipeline.h"
#include "solve/rigs/marker_rigidity.h"

namespace risorius {
namespace {

constexpr std::string_view kAuto = ":auto";
constexpr double kOtherFaceMm = 20;

/// Without a range the whole take is the neutral.
std::uint64_t last_frame_of(TakeReader& take) {
  if (take.info().frame_count && *take.info().frame_count > 0) return *take.info().frame_count - 1;
  MarkerFrame frame;
  std::uint64_t count = 0;
  take.rewind();
  while (take.next(frame)) ++count;
  if (count == 0) throw UserError(take.info().path.string(), "has no frames", "give a take with a neutral face");
  return count - 1;
}

}  // namespace

NeutralPlace parse_neutral_place(const std::string& text) {
  if (!text.ends_with(kAuto)) return {parse_take_range(text), false};
  return {parse_take_range(text.substr(0, text.size() - kAuto.size())), true};
}

ChosenNeutral read_neutral(TakeReader& take, const NeutralPlace& place) {
  const std::string path = place.range.path.string();
  std::uint64_t first = place.range.first.value_or(0), last = place.range.last.value_or(0);
  if (place.is_auto) {
    take.rewind();
    std::vector<MarkerFrame> frames = read_despiked(take, {});
    const auto from = static_cast<std::size_t>(std::min<std::uint64_t>(first, frames.size()));
    const auto to =
        place.range.last ? static_cast<std::size_t>(std::min<std::uint64_t>(last + 1, frames.size())) : frames.size();
    frames = {frames.begin() + static_cast<std::ptrdiff_t>(from),
              frames.begin() + static_cast<std::ptrdiff_t>(std::max(from, to))};
    const auto found = neutral_candidates(frames, {.most = 1});
    if (found.empty()) {
      throw UserError(path, "no stretch in which the face may be at rest was found",
                      "name one: TAKE:FROM-TO (risorius neutral TAKE shows candidates)");
    }
    first = from + found.front().first, last = from + found.front().last;
  } else if (!place.range.last) {
    last = last_frame_of(take);
  }
  ChosenNeutral chosen{.neutral = neutral_of(take, first, last), .place = fmt::format("{}:{}-{}", path, first, last)};
  if (chosen.neutral.motion_rms_mm > kLargestMotionMm) {
    throw UserError(chosen.place,
                    fmt::format("the face is not at rest: its markers move by {:.1f} mm rms about their medians",
                                chosen.neutral.motion_rms_mm),
                    "is the take's unit right? Else name a still stretch, TAKE:FROM-TO, or TAKE:auto; risorius neutral "
                    "TAKE shows candidates");
  }
  return chosen;
}

std::string doubt_of(const RenewedRig& renewed) {
  if (renewed.moved_rms_mm <= kDoubtedShiftMm) return "";
  return fmt::format(
      "{}: its face is {:.1f} mm rms from the neutral before, most {} by {:.1f} mm: is it at rest there? "
      "risorius neutral TAKE -o PICTURE shows where a face rests",
      renewed.place, renewed.moved_rms_mm, renewed.moved_most_marker, renewed.moved_most_mm);
}

RenewedRig with_neutral(const Rig& rig, const Neutral& neutral, const std::string& place) {
  const std::vector<int> index = index_map(neutral.marker_names, rig.marker_names);
  std::vector<Eigen::Vector3d> from(index.size(), Eigen::Vector3d::Zero()), to;
  std::vector<double> weight(index.size(), 0);
  for (std::size_t m = 0; m < index.size(); ++m) {
    to.emplace_back(rig.neutral_mm.col(static_cast<Eigen::Index>(m)));
    if (index[m] < 0 || !neutral.position_mm.col(index[m]).allFinite()) continue;
    from[m] = neutral.position_mm.col(index[m]);
    weight[m] = 1;
  }
  double seen = 0;
  for (const double w : weight) seen += w;
  if (2 * seen < static_cast<double>(index.size())) {
    throw UserError(place, fmt::format("has {} of the rig's {} markers", seen, index.size()),
                    "is it a take of this rig's layout?");
  }
  const RigidAlignment head_from_world = align_majority(from, to, weight);
  if (!head_from_world.determined) throw UserError(place, "its markers are on one line", "choose other frames");
  RenewedRig renewed{.rig = rig, .place = place};
  double squares = 0;
  for (std::size_t m = 0; m < index.size(); ++m) {
    if (weight[m] == 0) continue;
    const Eigen::Vector3d laid = head_from_world.to_from * from[m];
    const double moved_mm = (laid - to[m]).norm();
    squares += moved_mm * moved_mm;
    if (moved_mm > renewed.moved_most_mm)
      renewed.moved_most_mm = moved_mm, renewed.moved_most_marker = rig.marker_names[m];
    renewed.rig.neutral_mm.col(static_cast<Eigen::Index>(m)) = laid;
  }
  renewed.moved_rms_mm = std::sqrt(squares / seen);
  if (renewed.moved_rms_mm > kOtherFaceMm) {
    throw UserError(place, fmt::format("its face is {:.0f} mm (rms) from the rig's neutral", renewed.moved_rms_mm),
                    "is it this actor's take; are unit and axes right?");
  }
  if (!problems_of(renewed.rig).empty())
    throw UserError(place, problems_of(renewed.rig).front(), "choose other frames");
  renewed.rig.source +=
      fmt::format("; neutral of {}, {} frames, markers moved by {:.2f} mm rms",
                  std::filesystem::path(place).filename().string(), neutral.frame_count, renewed.moved_rms_mm);
  return renewed;
}

}  // namespace risorius
