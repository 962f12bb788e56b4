// The stage that turns markers into action units: head pose, then intensities 0 <= x <= upper bound that minimise
//     1/2 sum_m w_m || sum_i x_i e_im - y_m ||^2 + penalties,   y_m = head_from_world p_m - E0_m      (solve/README.md)
// with robust weights. Missing and rejected markers have weight 0, filled ones the weight of their stated error.
// An AU too little of which is measured (filled markers hold the face together, but see nothing) is not fitted: it
// keeps its last observed value (kHeld) or 0 (kNotObserved), which enters the fit of the others as a constant. A frame
// that leaves the pose undetermined holds pose and AUs. Input: MarkerFrames of the marker set given; output: one
// AuFrame each. One thread; use_marker_set and set_neutral between frames only. A flush ends the take: the next frame
// is solved as if it were the first.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/counters.h"
#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/stage.h"
#include "solve/au_solver_options.h"
#include "solve/face_fit.h"
#include "solve/mirror_check.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/rig_markers.h"
#include "solve/stabiliser_pose.h"

namespace risorius {

class AuSolver {
 public:
  /// Throws UserError with every problem of the rig, std::invalid_argument for options out of range.
  explicit AuSolver(Rig rig, const AuSolverOptions& options = {});

  /// Maps the rig's markers to the set by name; markers that the rig does not know are ignored. Intensities carry over.
  /// Throws UserError naming the missing markers if fewer than 3 stabilisers or less than half of the markers are
  /// there.
  void use_marker_set(const MarkerSet& set);

  /// Replaces the neutral positions (3 x M, head frame, in the rig's order) and keeps the basis. Throws UserError.
  void set_neutral(const Eigen::Matrix3Xd& neutral_mm);

  bool push(const MarkerFrame& frame) noexcept;  ///< refuses (and counts) frames of another marker set
  bool pop(AuFrame& frame) noexcept;
  void tick(Tick) noexcept {}
  void flush() noexcept { fresh_ = true; }
  const StageLedger& ledger() const noexcept { return ledger_; }

  const Rig& rig() const noexcept { return rig_; }
  std::uint32_t au_set_id() const noexcept { return au_set_id_; }

  /// Of the last solved frame: where the rig says that its markers are, 3 x M in world mm.
  void predict_markers(Eigen::Matrix3Xd& world_mm) const noexcept;
  /// Of the residuals per axis over the last second, which is what the next frame's L1 is weighed by.
  double residual_variance_mm2() const noexcept { return variance_mm2_; }
  /// Of the last solved frame: the final weight of each rig marker, 0 (not used) to 1.
  const Eigen::VectorXd& marker_weights() const noexcept { return fit_.weight(); }
  /// The same times what a stabiliser pulls harder than other markers: as the sum of squares counts them.
  const Eigen::VectorXd& pulling_weights() const noexcept { return fit_.pulling_weight(); }

 private:
  void start_take() noexcept;
  void solve(const MarkerFrame& frame, AuFrame& out) noexcept;
  bool find_pose(std::int64_t capture_time_ns) noexcept;
  bool anything_measured() const noexcept;
  bool refine_pose() noexcept;
  void decide_observed() noexcept;
  bool gives_up_aus() noexcept;
  bool begin_penalties(std::int64_t capture_time_ns) noexcept;
  void fit() noexcept { fit_.fit(rig_, markers_, world_from_head_); }
  void learn_residuals(double step_s) noexcept;
  void publish(const QpResult& qp, AuFrame& out) noexcept;
  void publish_intensities(double noise_mm, bool converged, AuFrame& out) noexcept;

  Rig rig_;
  AuSolverOptions options_;
  RigMarkers markers_;
  StabiliserPose stabiliser_pose_;
  MirrorCheck mirror_check_;
  FaceFit fit_;
  std::uint32_t au_set_id_;

  // The state that lasts from frame to frame, beside the intensities in fit_.
  bool fresh_ = true;
  std::int64_t last_time_ns_ = 0;
  double last_cost_mm2_ = 0;
  double variance_mm2_ = 0;  // of the residuals per axis, over the last second
  RigidTransform world_from_head_;
  std::vector<char> seen_;  // K: observed since the take began

  // Of the frame at work, allocated once. M markers, K AUs.
  Eigen::VectorXd measured_weight_;                   // M
  std::vector<char> observed_, follows_;              // K
  Eigen::VectorXd share_, fixed_, upper_, variance_;  // K
  AuFrame out_;
  bool has_out_ = false;
  StageLedger ledger_;
};

static_assert(Stage<AuSolver, MarkerFrame, AuFrame>);

}  // namespace risorius
