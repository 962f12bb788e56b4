// What is known of the markers of one face while it streams, and what it says of those that are hidden: how markers
// move together (MarkerCovariance) and what a marker's own past adds to that (ResidualMemory). Learns 60 times a
// second, whatever the rate.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "capture/repair/marker_covariance.h"
#include "capture/repair/residual_memory.h"

namespace risorius {

/// Where a hidden marker is, in the head frame, and the variance of that per axis.
struct MarkerFill {
  Eigen::Vector3d position_head_mm;
  double variance_mm2;
};

class FillModel {
 public:
  /// Throws UserError for an option out of its range.
  explicit FillModel(MarkerCovarianceOptions options = {}) : covariance_(options) {}

  /// Allocates. Marker i takes over what was known of old_index[i]; -1 is a marker never seen.
  void remap(const std::vector<int>& old_index);
  /// As MarkerCovariance::know.
  void know(std::shared_ptr<const KnownMotion> motion, const std::vector<std::string>& names) {
    covariance_.know(std::move(motion), names);
  }
  void reset() noexcept;

  /// Takes in a frame: positions in the head frame, and which markers are measured (1). One that shows too little of
  /// the face to learn from is not observed: the last frame's word is held. step_s: after the frame before.
  void observe(const std::vector<Eigen::Vector3d>& position_head_mm, const std::vector<std::uint8_t>& measured,
               double step_s) noexcept;
  /// Learns from what was observed, if a tick has passed. Once per frame, observed (`is_informed`) or not,
  /// `step_s` after the one before.
  void learn(const std::vector<std::uint8_t>& measured, double step_s, bool is_informed) noexcept;

  /// Where marker i was of late (a mean of some 20 ms), in the head frame.
  const Eigen::Vector3d& stayed_head_mm(std::size_t i) const noexcept { return stayed_head_mm_[i]; }
  /// Of a marker measured last gap_s ago. The variance is the one that such statements had of markers that the model
  /// went on learning from; in a gap it does not (FillRehearsal).
  MarkerFill estimate(std::size_t i, double gap_s) noexcept;
  /// What a marker's own past adds to what the others say.
  const ResidualMemory& residuals() const noexcept { return residuals_; }

  /// Time constant of stayed_head_mm().
  static constexpr double kLatelyS = 0.02;

 private:
  void take_over_shifts(const std::vector<std::uint8_t>& measured) noexcept;

  MarkerCovariance covariance_;
  ResidualMemory residuals_;
  std::vector<Eigen::Vector3d> stayed_head_mm_;
  double since_tick_s_ = 0;  ///< from the frame last learnt from, to the one last observed
};

}  // namespace risorius
