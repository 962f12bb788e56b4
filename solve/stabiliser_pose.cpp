#include "solve/stabiliser_pose.h"

namespace risorius {
namespace {

constexpr int kFewestStabilisers = 3;

}  // namespace

StabiliserPose::StabiliserPose(const Rig& rig, const HeadPoseOptions& options)
    : head_pose_(rig.marker_count(), options) {
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    if (rig.stabiliser_weight[static_cast<Eigen::Index>(m)] > 0) stabilisers_.push_back(static_cast<int>(m));
  }
  head_mm_.resize(stabilisers_.size());
  world_mm_.resize(stabilisers_.size());
  weight_.resize(stabilisers_.size());
}

bool StabiliserPose::is_possible(const RigMarkers& markers) const noexcept {
  int visible = 0;
  for (const int m : stabilisers_) visible += markers.weight()[m] > 0 ? 1 : 0;
  return visible >= kFewestStabilisers;
}

HeadPoseResult StabiliserPose::estimate(const Rig& rig, const RigMarkers& markers) noexcept {
  for (std::size_t s = 0; s < stabilisers_.size(); ++s) {
    const int m = stabilisers_[s];
    head_mm_[s] = rig.neutral_mm.col(m);
    world_mm_[s] = markers.world_mm(static_cast<std::size_t>(m));
    weight_[s] = rig.stabiliser_weight[m] * markers.weight()[m];
  }
  return head_pose_.estimate(head_mm_, world_mm_, weight_);
}

}  // namespace risorius
