// Whether the markers seen are the mirror image of the rig's face, as they are where a source states its axes wrongly.
// Faces are nearly symmetric, so that a mirrored one is not far from any rig; but its mirror image is much nearer.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/rigs/rig.h"
#include "solve/rigs/rig_markers.h"

namespace risorius {

class MirrorCheck {
 public:
  explicit MirrorCheck(const Rig& rig);
  /// Allocates nothing.
  bool looks_mirrored(const Rig& rig, const RigMarkers& markers) noexcept;

 private:
  double mean_square_mm2() const noexcept;

  std::vector<Eigen::Vector3d> head_mm_, world_mm_;
  std::vector<double> weight_;
};

}  // namespace risorius
