#include "solve/rigs/recording_heads.h"

#include <algorithm>

#include "solve/head_pose.h"
#include "solve/rigs/marker_rigidity.h"
#include "solve/rigs/rigid_part.h"
#include "solve/rigs/stabilisers.h"

namespace risorius {
namespace {

/// A stabiliser that the AU is expected to carry along this far cannot hold the head at first; its say on which rigid
/// motion is the head's has halved.
constexpr double kMovedStabiliserMm = 1.0;
constexpr double kOutlierScales = 4;
/// By how much of what is expected an actor's AU may be larger or smaller on the stabilisers.
constexpr double kLeastScale = 0.3, kMostScale = 3;

/// The rig's stabilisers without those that this AU is expected to move, unless too few would be left.
Eigen::VectorXd stabilisers_for(const Rig& rig, const RigAu* expected) {
  Eigen::VectorXd weight = rig.stabiliser_weight;
  if (expected == nullptr) return weight;
  for (Eigen::Index m = 0; m < weight.size(); ++m) {
    if (expected->displacement_mm.col(m).norm() > kMovedStabiliserMm) weight[m] = 0;
  }
  return hold_still(rig.neutral_mm, weight) ? weight : rig.stabiliser_weight;
}

/// A frame as the alignments want it; weight 0 and the origin where it was not measured.
struct Seen {
  std::vector<Eigen::Vector3d> world_mm;
  std::vector<double> weight;
};

Seen seen_in(const Eigen::Matrix3Xd& frame_mm) {
  Seen seen;
  for (const Eigen::Vector3d p : frame_mm.colwise()) {
    seen.weight.push_back(p.allFinite() ? 1 : 0);
    seen.world_mm.push_back(p.allFinite() ? p : Eigen::Vector3d::Zero());
  }
  return seen;
}

std::vector<Eigen::Vector3d> columns_of(const Eigen::Matrix3Xd& points) {
  std::vector<Eigen::Vector3d> columns;
  for (const Eigen::Vector3d p : points.colwise()) columns.push_back(p);
  return columns;
}

}  // namespace

RecordingHeads::RecordingHeads(const Rig& rig, const std::vector<Eigen::Matrix3Xd>& world_mm, const RigAu* expected)
    : rig_(rig), world_mm_(world_mm), expected_(expected) {
  const Eigen::VectorXd stabiliser = stabilisers_for(rig, expected);
  const std::vector<Eigen::Vector3d> neutral = columns_of(rig.neutral_mm);
  HeadPose pose(rig.marker_count(), HeadPoseOptions{});
  for (std::size_t t = 0; t < world_mm.size(); ++t) {
    Seen seen = seen_in(world_mm[t]);
    for (std::size_t m = 0; m < seen.weight.size(); ++m) seen.weight[m] *= stabiliser[static_cast<Eigen::Index>(m)];
    const HeadPoseResult head = pose.estimate(neutral, seen.world_mm, seen.weight);
    if (head.determined) heads_.push_back({t, head.world_from_head.inverse()});
  }
}

Displacements RecordingHeads::displacements() const {
  const Eigen::Index markers = rig_.neutral_mm.cols();
  Displacements result;
  for (const Head& head : heads_) {
    Eigen::Matrix3Xd& d_mm = result.d_mm.emplace_back(Eigen::Matrix3Xd::Zero(3, markers));
    Eigen::VectorXd& weight = result.weight.emplace_back(Eigen::VectorXd::Zero(markers));
    for (Eigen::Index m = 0; m < markers; ++m) {
      const Eigen::Vector3d p = world_mm_[head.frame].col(m);
      if (!p.allFinite()) continue;
      weight[m] = 1;
      d_mm.col(m) = head.head_from_world * p - rig_.neutral_mm.col(m);
    }
  }
  return result;
}

void RecordingHeads::align_to(const Eigen::Matrix3Xd& rest_mm, const RankOneMotion& motion) {
  const Eigen::Matrix3Xd at_rest = rig_.neutral_mm + rest_mm;
  const double least_scale_mm = std::max(kOutlierScales * motion.noise_mm, 1e-3);
  for (std::size_t t = 0; t < heads_.size(); ++t) {
    const Eigen::Matrix3Xd face = at_rest + motion.amplitude[static_cast<Eigen::Index>(t)] * motion.field_mm;
    const Seen seen = seen_in(world_mm_[heads_[t].frame]);
    const RigidAlignment aligned = align_majority(seen.world_mm, columns_of(face), seen.weight, least_scale_mm);
    if (aligned.determined) heads_[t].head_from_world = aligned.to_from;
  }
}

Eigen::Matrix3Xd RecordingHeads::without_head_motion(const Eigen::Matrix3Xd& field_mm) const {
  Eigen::Matrix3Xd wanted = Eigen::Matrix3Xd::Zero(3, field_mm.cols());
  if (expected_ != nullptr) {
    const Eigen::Matrix3Xd& e = expected_->displacement_mm;
    const double scale = field_mm.cwiseProduct(e).sum() / std::max(e.squaredNorm(), 1e-12);
    wanted = std::clamp(scale, kLeastScale, kMostScale) * e;
  }
  Eigen::VectorXd weight = rig_.stabiliser_weight;
  for (Eigen::Index m = 0; m < weight.size(); ++m) {
    const double share = wanted.col(m).norm() / kMovedStabiliserMm;
    weight[m] /= 1 + share * share;
  }
  return field_mm - rigid_part(rig_.neutral_mm, field_mm - wanted, weight);
}

}  // namespace risorius
