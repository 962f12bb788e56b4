// A whole take in the head's frame, for what is repaired offline: the head pose of every frame, and the measured
// positions that it carries there. Where the measured markers leave a pose open (a whole-frame drop-out) it is
// interpolated between its neighbours in time, and held at the ends of the take.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/marker_set.h"
#include "capture/repair/head_frame.h"

namespace risorius {

/// Entries of marker i in frame f stand at f * markers + i.
struct HeadTake {
  std::size_t frames = 0, markers = 0;
  std::vector<Eigen::Vector3d> position_mm;  ///< head frame; zero where not measured
  std::vector<std::uint8_t> measured;
  std::vector<RigidTransform> head_from_world;  ///< by frame
  std::vector<double> time_s;                   ///< by frame, from the first
  bool has_pose = false;                        ///< of at least one frame; otherwise everything is the identity's

  std::size_t at(std::size_t f, std::size_t i) const noexcept { return f * markers + i; }
  /// Makes marker i of the frame a filled one. The position is in the head frame.
  void set_filled(MarkerFrame& frame, std::size_t f, std::size_t i, const Eigen::Vector3d& position_head_mm,
                  double standard_deviation_mm) const noexcept;
};

/// Learns the head's shape in one pass and takes every pose against it in a second one.
HeadTake carry_into_head_frame(const std::vector<MarkerFrame>& frames, const MarkerSet& set,
                               const HeadFrameOptions& options);

}  // namespace risorius
