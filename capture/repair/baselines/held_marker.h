// The plain causal ways to fill a gap, kept to be measured against: a marker stays where it was on the head, or goes on
// as it went and comes to rest.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// Where a marker was last, and how fast it went; in the head frame.
class HeldMarker {
 public:
  void observe(const Eigen::Vector3d& position_mm, double step_s) noexcept;
  /// The marker was not seen for a step.
  void miss(double step_s) noexcept { gap_s_ += step_s; }

  bool seen() const noexcept { return seen_; }
  double gap_s() const noexcept { return gap_s_; }
  const Eigen::Vector3d& hold_mm() const noexcept { return position_mm_; }
  /// The last velocity goes on and dies away with time constant kDampingS.
  Eigen::Vector3d damped_mm() const noexcept;
  /// Of the error of either per axis: what the marker strayed in steps of this length so far.
  double variance_mm2() const noexcept;

  static constexpr double kDampingS = 0.1;

 private:
  Eigen::Vector3d position_mm_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mm_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_mm_ = Eigen::Vector3d::Zero();
  double spread_mm2_ = 4;   ///< about the mean, per axis
  double step_mm2_ = 0.04;  ///< of a frame's move, per axis
  double step_s_ = 1.0 / 60;
  double samples_ = 0;
  double gap_s_ = 0;
  bool seen_ = false;
};

}  // namespace risorius
