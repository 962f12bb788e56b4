// Where the head is, frame by frame: the rigid motion that carries the measured markers onto a reference shape.
// Markers that deform little count most; the weights are given by name, or learnt. A robust loss (Geman-McClure,
// iteratively reweighted) keeps an open jaw or a false track from bending it.
// The reference starts as the first frame that is complete enough, grows as markers appear, and settles to their mean.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "capture/frames.h"
#include "capture/rigid_alignment.h"

namespace risorius {

/// Weight by marker name, > 0; names that a set does not have are ignored.
using StabiliserWeights = std::vector<std::pair<std::string, double>>;

struct HeadFrameOptions {
  StabiliserWeights stabilisers;        ///< empty: weights are learnt
  double reference_completeness = 0.7;  ///< share of the markers that the first reference frame must have, (0, 1]
  double memory_s = 30;                 ///< time constant of the reference and the learnt weights, > 0
};

class HeadFrame {
 public:
  /// Throws UserError for an option out of its range.
  explicit HeadFrame(HeadFrameOptions options = {});

  /// Allocates. What is known of markers of the same name is kept.
  void use_names(const std::vector<std::string>& names);
  /// Forgets the reference and the learnt weights.
  void reset() noexcept;

  /// Aligns the measured markers of the frame (count = the names' count; positions of other markers are not read).
  /// Returns whether the pose is determined; if not, head_from_world() remains the last one that was.
  bool process(const MarkerFrame& frame) noexcept;
  /// Learns reference and weights from the frame last processed, from the markers that are `trusted` (1) only.
  void learn(double step_s, const std::vector<std::uint8_t>& trusted) noexcept;

  bool determined() const noexcept { return determined_; }
  const RigidTransform& head_from_world() const noexcept { return head_from_world_; }
  /// Which markers of the frame last processed were measured, finite and not far outside of all others: a single one
  /// at a distance of some hundred metres would turn the whole frame. A head is nowhere near as large.
  const std::vector<std::uint8_t>& measured() const noexcept { return measured_; }
  /// Positions of the measured markers of the frame last processed, in the head frame (mm).
  const std::vector<Eigen::Vector3d>& position_head_mm() const noexcept { return position_head_mm_; }

 private:
  bool start_reference(const MarkerFrame& frame) noexcept;
  void leave_out_far_markers() noexcept;
  double weight_of(std::size_t i) const noexcept;
  bool align() noexcept;

  HeadFrameOptions options_;
  std::vector<std::string> names_;
  std::vector<double> given_weight_;           ///< by marker; empty if learnt
  std::vector<Eigen::Vector3d> reference_mm_;  ///< head frame
  std::vector<double> samples_;                ///< behind the reference; 0 = not in the reference
  std::vector<double> deformation_mm2_;        ///< mean squared distance from the reference
  std::vector<Eigen::Vector3d> position_world_mm_, position_head_mm_;
  std::vector<double> weight_, scratch_;
  std::vector<std::uint8_t> measured_;
  bool has_reference_ = false;
  bool determined_ = false;
  RigidTransform head_from_world_;
};

}  // namespace risorius
