#include "replay/dataset/marker_energy.h"

#include <cmath>

#include "capture/rigid_alignment.h"

namespace risorius {
namespace {

RigidTransform world_from_head(const Pose& pose) {
  const auto& q = pose.rotation_xyzw;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]),
          Eigen::Vector3d(pose.translation_mm[0], pose.translation_mm[1], pose.translation_mm[2])};
}

double explained(double remaining, double of) noexcept { return of > 0 ? 1 - remaining / of : 0; }

}  // namespace

MarkerEnergy::MarkerEnergy(const Rig& rig, const std::vector<std::string>& marker_names)
    : neutral_mm_(rig.neutral_mm), set_index_(index_map(marker_names, rig.marker_names)) {
  for (const auto& au : rig.aus) fields_mm_.push_back(au.displacement_mm);
}

void MarkerEnergy::add(const SolvedFrame& frame) {
  if (frame.aus.status != SolverStatus::kConverged) return;
  if (!first_pose_) first_pose_ = frame.aus.world_from_head;
  const RigidTransform first = world_from_head(*first_pose_), now = world_from_head(frame.aus.world_from_head);
  const RigidTransform head_from_world = now.inverse();
  for (std::size_t m = 0; m < set_index_.size(); ++m) {
    const auto i = static_cast<std::size_t>(set_index_[m]);
    if (set_index_[m] < 0 || frame.markers.state[i] != MarkerState::kMeasured) continue;
    const auto column = static_cast<Eigen::Index>(m);
    const Position& p = frame.markers.position_mm[i];
    const Eigen::Vector3d p_world(p.x, p.y, p.z);
    Eigen::Vector3d rest = head_from_world * p_world - neutral_mm_.col(column);
    total_ += (p_world - first * neutral_mm_.col(column)).squaredNorm();
    rigid_ += rest.squaredNorm();
    for (std::size_t k = 0; k < fields_mm_.size(); ++k) rest -= frame.aus.intensity[k] * fields_mm_[k].col(column);
    aus_ += rest.squaredNorm();
    samples_ += 1;
  }
}

double MarkerEnergy::explained_by_head() const noexcept { return explained(rigid_, total_); }
double MarkerEnergy::explained_with_aus() const noexcept { return explained(aus_, total_); }
double MarkerEnergy::face_explained_by_aus() const noexcept { return explained(aus_, rigid_); }
double MarkerEnergy::residual_rms_mm() const noexcept { return samples_ > 0 ? std::sqrt(aus_ / samples_) : 0; }

}  // namespace risorius
