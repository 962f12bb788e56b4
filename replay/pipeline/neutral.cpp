#include "replay/pipeline/neutral.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "capture/errors.h"
#include "capture/rigid_alignment.h"

namespace risorius {
namespace {

constexpr std::size_t kStillTwentieths = 19;
constexpr std::uint64_t kMostFrames = 20000;  // a neutral is seconds; this is 80 s at 250 Hz

/// The markers of one frame: positions (not read where the weight is 0) and weights 1 or 0.
struct Points {
  std::vector<Eigen::Vector3d> position_mm;
  std::vector<double> weight;
};

Points points_of(const MarkerFrame& frame) {
  Points points{std::vector<Eigen::Vector3d>(frame.count, Eigen::Vector3d::Zero()),
                std::vector<double>(frame.count, 0)};
  for (std::size_t m = 0; m < frame.count; ++m) {
    const Position& p = frame.position_mm[m];
    points.position_mm[m] = {p.x, p.y, p.z};
    points.weight[m] = frame.state[m] == MarkerState::kMeasured && points.position_mm[m].allFinite() ? 1 : 0;
  }
  return points;
}

/// Carries a frame onto the reference by the markers that both have.
RigidAlignment align(const Points& frame, const Points& reference) {
  std::vector<double> both(frame.weight.size());
  for (std::size_t m = 0; m < both.size(); ++m) both[m] = frame.weight[m] * reference.weight[m];
  return align_rigid(frame.position_mm, reference.position_mm, both);
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Aligned positions, by marker.
using Samples = std::vector<std::vector<Eigen::Vector3d>>;

void set_medians(const Samples& samples, Neutral& neutral) {
  double squares = 0, count = 0;
  std::vector<double> values;
  for (std::size_t m = 0; m < samples.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    neutral.measured_count.push_back(samples[m].size());
    if (samples[m].empty()) continue;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      values.clear();
      for (const Eigen::Vector3d& p : samples[m]) values.push_back(p[axis]);
      neutral.position_mm(axis, column) = median_of(values);
    }
    values.clear();
    for (const Eigen::Vector3d& p : samples[m]) values.push_back((p - neutral.position_mm.col(column)).squaredNorm());
    // A few false tracks leap by centimetres while the face is still.
    std::ranges::sort(values);
    values.resize(std::max<std::size_t>(1, values.size() * kStillTwentieths / 20));
    for (const double squared : values) squares += squared;
    count += static_cast<double>(values.size());
  }
  neutral.motion_rms_mm = std::sqrt(squares / count);
}

}  // namespace

Neutral neutral_of(TakeReader& take, std::uint64_t first, std::uint64_t last) {
  const std::string place = fmt::format("{}:{}-{}", take.info().path.string(), first, last);
  if (last < first) throw UserError(place, "an empty range", "give FIRST-LAST with LAST not before FIRST");
  if (last - first >= kMostFrames)
    throw UserError(place, fmt::format("more than {} frames", kMostFrames), "choose a shorter stretch");

  Neutral neutral;
  neutral.marker_names = take.info().markers.names;
  const std::size_t marker_count = neutral.marker_names.size();
  neutral.position_mm.setConstant(3, static_cast<Eigen::Index>(marker_count), std::numeric_limits<double>::quiet_NaN());
  Samples samples(marker_count);
  Points reference;
  MarkerFrame frame;
  take.rewind();
  std::uint64_t index = 0;
  for (; index <= last && take.next(frame); ++index) {
    if (index < first) continue;
    const Points points = points_of(frame);
    const RigidAlignment alignment = align(points, neutral.frame_count == 0 ? points : reference);
    if (!alignment.determined) {
      ++neutral.skipped_count;
      continue;
    }
    if (neutral.frame_count++ == 0) reference = points;
    for (std::size_t m = 0; m < std::min(marker_count, points.weight.size()); ++m) {
      if (points.weight[m] > 0) samples[m].push_back(alignment.to_from * points.position_mm[m]);
    }
  }
  if (index <= last)
    throw UserError(place, fmt::format("the take ends after {} frames", index), "choose a range inside the take");
  if (neutral.frame_count == 0)
    throw UserError(place, "no frame with three markers off one line", "choose frames with more markers");
  set_medians(samples, neutral);
  return neutral;
}

}  // namespace risorius
