// The rig's markers in a marker frame: found by name in the frame's marker set, with the weight that their state gives
// them. Measured 1; filled s0^2 / (s0^2 + s^2) with the noise s0 and the stated standard deviation s; missing,
// rejected, not finite, implausibly far or not in the set 0.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// "12 of the rig's 55 markers are not in the marker set: A, B, ... and 4 more"; empty if all are.
std::string describe_absent_markers(const Rig& rig, const MarkerSet& set);

class RigMarkers {
 public:
  RigMarkers(const Rig& rig, double noise_mm);

  /// Throws UserError naming the missing markers if fewer than 3 stabilisers or less than half of the markers are in
  /// the set.
  void use_marker_set(const Rig& rig, const MarkerSet& set);

  /// Whether the frame is one of the set given.
  bool accepts(const MarkerFrame& frame) const noexcept {
    return set_count_ > 0 && frame.header.set_id == set_id_ && frame.count == set_count_;
  }
  /// Reads a frame that it accepts. Does not allocate.
  void read(const MarkerFrame& frame) noexcept;

  /// M, 1 for markers that the set has, else 0.
  const Eigen::VectorXd& present() const noexcept { return present_; }
  /// M, 0 to 1.
  const Eigen::VectorXd& weight() const noexcept { return weight_; }
  bool is_measured(std::size_t m) const noexcept { return measured_[m] != 0; }
  /// Finite; without meaning where the weight is 0.
  const Eigen::Vector3d& world_mm(std::size_t m) const noexcept { return world_mm_[m]; }

 private:
  double noise_mm_;
  std::uint32_t set_id_ = 0;
  std::uint32_t set_count_ = 0;  // markers in the set; 0 = none given yet
  std::vector<int> index_;       // of each rig marker in the set, or -1
  Eigen::VectorXd present_, weight_;
  std::vector<char> measured_;
  std::vector<Eigen::Vector3d> world_mm_;
};

}  // namespace risorius
