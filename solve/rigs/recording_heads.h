// Where the head is in each frame of a calibration recording: first by the stabilisers alone, then, once it is known
// how the face moves, by all markers. Which rigid motion belongs to the head and which to the AU the markers cannot
// tell; the stabilisers decide it: what the AU does there is as expected of it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/rigid_alignment.h"
#include "solve/rigs/rank_one_motion.h"
#include "solve/rigs/rig.h"

namespace risorius {

class RecordingHeads {
 public:
  /// `world_mm`: per frame 3 x M in the rig's marker order, NaN where not measured. `expected`: what the rig says of
  /// the recorded AU, nullptr if nothing. Keeps the references. Frames in which no head can be found are left out.
  RecordingHeads(const Rig& rig, const std::vector<Eigen::Matrix3Xd>& world_mm, const RigAu* expected);

  /// From the neutral, under the heads as known now.
  Displacements displacements() const;
  std::size_t frame_count() const noexcept { return heads_.size(); }

  /// Finds every head anew, with all markers where `rest_mm` (3 x M, from the neutral) and `motion` say.
  void align_to(const Eigen::Matrix3Xd& rest_mm, const RankOneMotion& motion);

  /// The field without the rigid motion by which it differs from what is expected of the stabilisers.
  Eigen::Matrix3Xd without_head_motion(const Eigen::Matrix3Xd& field_mm) const;

 private:
  struct Head {
    std::size_t frame;
    RigidTransform head_from_world;
  };
  const Rig& rig_;
  const std::vector<Eigen::Matrix3Xd>& world_mm_;
  const RigAu* expected_;
  std::vector<Head> heads_;
};

}  // namespace risorius
