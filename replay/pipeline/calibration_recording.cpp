#include "replay/pipeline/calibration_recording.h"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

#include "capture/errors.h"
#include "capture/marker_set.h"

namespace risorius {
namespace {

constexpr std::size_t kMostFrames = 20000;

Eigen::Matrix3Xd positions_of(const MarkerFrame& frame, const std::vector<int>& index) {
  Eigen::Matrix3Xd positions =
      Eigen::Matrix3Xd::Constant(3, static_cast<Eigen::Index>(index.size()), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t m = 0; m < index.size(); ++m) {
    if (index[m] < 0) continue;
    const auto i = static_cast<std::size_t>(index[m]);
    if (frame.state[i] != MarkerState::kMeasured) continue;
    const Position& p = frame.position_mm[i];
    positions.col(static_cast<Eigen::Index>(m)) = Eigen::Vector3d(p.x, p.y, p.z);
  }
  return positions;
}

}  // namespace

CalibrationRecording calibration_recording_of(TakeReader& take, const TakeRange& range, const Rig& rig,
                                              const std::string& au) {
  std::string place = range.path.string();
  if (range.first) place += fmt::format(":{}-{}", *range.first, *range.last);
  const std::vector<int> index = index_map(take.info().markers.names, rig.marker_names);
  const auto found = std::ranges::count_if(index, [](int i) { return i >= 0; });
  if (2 * static_cast<std::size_t>(found) < index.size()) {
    throw UserError(place, fmt::format("has {} of the neutral's {} markers", found, index.size()),
                    "record neutral and AUs with the same marker names");
  }
  CalibrationRecording recording{.au = au, .place = place, .world_mm = {}};
  MarkerFrame frame;
  take.rewind();
  std::uint64_t number = 0;
  for (; (!range.last || number <= *range.last) && take.next(frame); ++number) {
    if (range.first && number < *range.first) continue;
    if (recording.world_mm.size() == kMostFrames) {
      throw UserError(place, fmt::format("more than {} frames for one AU", kMostFrames), "give TAKE:FROM-TO");
    }
    recording.world_mm.push_back(positions_of(frame, index));
  }
  if (range.last && number <= *range.last) {
    throw UserError(place, fmt::format("the take ends after {} frames", number), "choose a range inside the take");
  }
  return recording;
}

}  // namespace risorius
