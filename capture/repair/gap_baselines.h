// The plain ways to fill gaps, kept to be measured against: hold and damped velocity (causal, in the head's frame, one
// marker at a time), and linear interpolation (offline, in world coordinates: the method of the seed 000 paper).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/frames.h"

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

/// Fills every gap between two measured samples on the straight line between them, in world coordinates; a marker that
/// is missing at an end of the take, or for longer than `max_gap_ns`, stays as it is. Sets state and
/// standard_deviation_mm (a random walk between the ends, with the take's own steps).
void fill_linear(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns);

}  // namespace risorius
