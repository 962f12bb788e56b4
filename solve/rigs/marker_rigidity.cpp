#include "solve/rigs/marker_rigidity.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/errors.h"
#include "capture/marker_set.h"

namespace risorius {
namespace {

constexpr int kSteps = 25;
constexpr double kFirstScaleMm = 10, kShrink = 0.85;
constexpr std::size_t kMostFrames = 1500;  // evenly chosen from longer takes

}  // namespace

RigidAlignment align_majority(const std::vector<Eigen::Vector3d>& from_mm, const std::vector<Eigen::Vector3d>& to_mm,
                              const std::vector<double>& weights, double least_scale_mm) {
  RigidAlignment alignment = align_rigid(from_mm, to_mm, weights);
  std::vector<double> trusted = weights;
  double scale_mm = kFirstScaleMm;
  for (int step = 0; step < kSteps && alignment.determined; ++step) {
    for (std::size_t m = 0; m < trusted.size(); ++m) {
      if (!(weights[m] > 0)) continue;
      const double share = (alignment.to_from * from_mm[m] - to_mm[m]).norm() / scale_mm;
      const double loss = 1 / (1 + share * share);
      trusted[m] = weights[m] * loss * loss;
    }
    const RigidAlignment next = align_rigid(from_mm, to_mm, trusted);
    if (!next.determined) break;
    alignment = next;
    scale_mm = std::max(least_scale_mm, kShrink * scale_mm);
  }
  return alignment;
}

Eigen::VectorXd marker_unrest_mm(const Rig& rig, const TakeFrames& take) {
  const std::vector<int> index = index_map(take.markers.names, rig.marker_names);
  const std::size_t markers = rig.marker_count();
  if (2 * static_cast<std::size_t>(std::ranges::count_if(index, [](int i) { return i >= 0; })) < markers) {
    throw UserError(take.place, "has less than half of the rig's markers", "is it a take of this layout?");
  }
  std::vector<Eigen::Vector3d> neutral, seen(markers, Eigen::Vector3d::Zero());
  for (const Eigen::Vector3d p : rig.neutral_mm.colwise()) neutral.push_back(p);
  std::vector<double> weights(markers);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(markers)), count = squares;
  const std::size_t stride = std::max<std::size_t>(1, take.frames.size() / kMostFrames);
  for (std::size_t t = 0; t < take.frames.size(); t += stride) {
    const MarkerFrame& frame = take.frames[t];
    for (std::size_t m = 0; m < markers; ++m) {
      const auto at = static_cast<std::size_t>(std::max(0, index[m]));
      weights[m] = index[m] >= 0 && frame.state[at] == MarkerState::kMeasured ? 1 : 0;
      seen[m] = {frame.position_mm[at].x, frame.position_mm[at].y, frame.position_mm[at].z};
    }
    const RigidAlignment head_from_world = align_majority(seen, neutral, weights);
    if (!head_from_world.determined) continue;
    for (std::size_t m = 0; m < markers; ++m) {
      if (weights[m] == 0) continue;
      squares[static_cast<Eigen::Index>(m)] += (head_from_world.to_from * seen[m] - neutral[m]).squaredNorm();
      count[static_cast<Eigen::Index>(m)] += 1;
    }
  }
  Eigen::VectorXd unrest_mm(squares.size());
  for (Eigen::Index m = 0; m < squares.size(); ++m) {
    unrest_mm[m] = count[m] > 0 ? std::sqrt(squares[m] / count[m]) : std::numeric_limits<double>::quiet_NaN();
  }
  return unrest_mm;
}

}  // namespace risorius
