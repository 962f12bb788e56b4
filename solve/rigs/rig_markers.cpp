#include "solve/rigs/rig_markers.h"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "capture/errors.h"

namespace risorius {
namespace {

/// Nothing that a camera volume holds is further away; beyond lies a decoding error.
constexpr float kFurthestMm = 1e6f;

/// False for NaN.
bool usable(const Position& p) noexcept {
  return std::abs(p.x) <= kFurthestMm && std::abs(p.y) <= kFurthestMm && std::abs(p.z) <= kFurthestMm;
}

}  // namespace

std::string describe_absent_markers(const Rig& rig, const MarkerSet& set) {
  constexpr std::size_t kMostNamed = 8;
  const std::vector<int> index = index_map(set.names, rig.marker_names);
  std::string names;
  std::size_t absent = 0;
  for (std::size_t m = 0; m < index.size(); ++m) {
    if (index[m] >= 0) continue;
    if (absent < kMostNamed) names += (absent == 0 ? "" : ", ") + rig.marker_names[m];
    ++absent;
  }
  if (absent == 0) return "";
  if (absent > kMostNamed) names += fmt::format(" and {} more", absent - kMostNamed);
  return fmt::format("{} of the rig's {} markers are not in the marker set: {}", absent, index.size(), names);
}

RigMarkers::RigMarkers(const Rig& rig, double noise_mm)
    : noise_mm_(noise_mm),
      index_(rig.marker_count(), -1),
      present_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rig.marker_count()))),
      weight_(present_),
      measured_(rig.marker_count(), 0),
      world_mm_(rig.marker_count(), Eigen::Vector3d::Zero()) {}

void RigMarkers::use_marker_set(const Rig& rig, const MarkerSet& set) {
  const std::vector<int> index = index_map(set.names, rig.marker_names);
  std::vector<std::string> missing;
  std::size_t stabilisers = 0;
  Eigen::VectorXd present = Eigen::VectorXd::Zero(present_.size());
  for (std::size_t m = 0; m < index.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    if (index[m] < 0) {
      missing.push_back(rig.marker_names[m]);
    } else {
      present[column] = 1;
      stabilisers += rig.stabiliser_weight[column] > 0;
    }
  }
  if (stabilisers < 3 || 2 * missing.size() > index.size()) {
    throw UserError("marker set " + std::to_string(set.id),
                    fmt::format("the rig does not match the take: {} of the rig's {} markers and {} of its {} "
                                "stabilisers are there; missing: {}",
                                index.size() - missing.size(), index.size(), stabilisers,
                                (rig.stabiliser_weight.array() > 0).count(), fmt::join(missing, ", ")),
                    "use the rig of this take, or map its marker names");
  }
  index_ = index;
  present_ = present;
  set_id_ = set.id;
  set_count_ = static_cast<std::uint32_t>(set.names.size());
}

void RigMarkers::read(const MarkerFrame& frame) noexcept {
  const double noise2 = noise_mm_ * noise_mm_;
  for (std::size_t m = 0; m < index_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    weight_[column] = 0;
    measured_[m] = 0;
    if (index_[m] < 0) continue;
    const auto i = static_cast<std::size_t>(index_[m]);
    const Position& p = frame.position_mm[i];
    if (!usable(p)) continue;
    world_mm_[m] = {p.x, p.y, p.z};
    if (frame.state[i] == MarkerState::kMeasured) {
      measured_[m] = 1;
      weight_[column] = 1;
    } else if (frame.state[i] == MarkerState::kFilled) {
      const double deviation = frame.standard_deviation_mm[i];
      const double weight = noise2 / (noise2 + deviation * deviation);
      if (weight > 0) weight_[column] = weight;  // false for NaN
    }
  }
}

}  // namespace risorius
