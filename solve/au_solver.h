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
#include <utility>
#include <vector>

#include "capture/counters.h"
#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/stage.h"
#include "solve/au_solver_options.h"
#include "solve/bounded_qp.h"
#include "solve/head_pose.h"
#include "solve/rigs/marker_basis.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/rig_markers.h"

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
  /// Of the last solved frame: the final weight of each rig marker, 0 (not used) to 1.
  const Eigen::VectorXd& marker_weights() const noexcept { return weight_; }

 private:
  void start_take() noexcept;
  void solve(const MarkerFrame& frame, AuFrame& out) noexcept;
  bool find_pose(std::int64_t capture_time_ns) noexcept;
  HeadPoseResult stabiliser_pose() noexcept;
  double truncated_mean_square_mm2() const noexcept;
  bool stabilisers_visible() const noexcept;
  bool anything_measured() const noexcept;
  bool refine_pose() noexcept;
  void decide_observed() noexcept;
  void prepare_penalties(std::int64_t capture_time_ns) noexcept;
  QpResult fit(QpEffort effort) noexcept;
  QpResult fit_weighted(QpEffort effort) noexcept;
  bool renew_hessian() noexcept;
  void project_markers() noexcept;
  void measure_residuals() noexcept;
  double median_residual_mm() noexcept;
  bool looks_mirrored() noexcept;
  bool reweigh(int iteration) noexcept;
  void publish(const QpResult& qp, AuFrame& out) noexcept;
  void publish_intensities(double noise_mm, bool converged, AuFrame& out) noexcept;
  double noise_from_residuals() const noexcept;

  Rig rig_;
  AuSolverOptions options_;
  RigMarkers markers_;
  MarkerBasis basis_;
  HeadPose head_pose_;
  BoundedQp qp_;
  std::uint32_t au_set_id_;
  std::vector<std::pair<int, int>> left_right_pairs_;
  std::vector<int> stabilisers_;  // rig markers

  // The state that lasts from frame to frame.
  bool fresh_ = true;
  std::int64_t last_time_ns_ = 0;
  double last_cost_mm2_ = 0;
  RigidTransform world_from_head_;
  Eigen::VectorXd x_;       // K
  std::vector<char> seen_;  // K: observed since the take began

  // Of the frame at work, allocated once. M markers, K AUs.
  Eigen::VectorXd weight_, measured_weight_;          // M
  Eigen::VectorXd gram_weight_;                       // M: the weights that h_ belongs to
  bool hessian_holds_ = false;                        // no penalty in h_ has changed since it was made
  Eigen::VectorXd y_mm_, weighted_y_mm_, fitted_mm_;  // 3M
  std::vector<double> residual_mm_, scratch_;         // M
  std::vector<Eigen::Vector3d> stabiliser_head_mm_, stabiliser_world_mm_;
  std::vector<double> stabiliser_weight_;
  std::vector<Eigen::Vector3d> fitted_head_mm_, seen_world_mm_;                                  // M
  std::vector<double> pose_weight_;                                                              // M
  std::vector<char> observed_;                                                                   // K
  Eigen::VectorXd share_, b_fit_, fixed_, upper_, solution_, variance_, temporal_, previous_x_;  // K
  Eigen::MatrixXd h_;                                                                            // K x K
  AuFrame out_;
  bool has_out_ = false;
  StageLedger ledger_;
};

static_assert(Stage<AuSolver, MarkerFrame, AuFrame>);

}  // namespace risorius
