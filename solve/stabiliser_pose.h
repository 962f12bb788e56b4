// world_from_head as the rig's stabilisers alone show it: the neutral's stabilisers against those seen, robust
// (head_pose.h). Allocates only when constructed.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/head_pose.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/rig_markers.h"

namespace risorius {

class StabiliserPose {
 public:
  StabiliserPose(const Rig& rig, const HeadPoseOptions& options);

  /// Whether so many stabilisers have a weight that a pose is possible.
  bool is_possible(const RigMarkers& markers) const noexcept;
  HeadPoseResult estimate(const Rig& rig, const RigMarkers& markers) noexcept;

 private:
  HeadPose head_pose_;
  std::vector<int> stabilisers_;  // rig markers
  std::vector<Eigen::Vector3d> head_mm_, world_mm_;
  std::vector<double> weight_;
};

}  // namespace risorius
