// One frame's fit of head pose and intensities to markers, jointly and with robust weights per marker: steps in which
// the exact bounded QP of solve/README.md, eq. 2, carries the head along (pose_coupling.h), and at last that QP in the
// pose found, certified. Knows nothing of time or of what a frame is published as. Allocates only when constructed.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "capture/rigid_alignment.h"
#include "solve/au_penalties.h"
#include "solve/au_solver_options.h"
#include "solve/bounded_qp.h"
#include "solve/pose_coupling.h"
#include "solve/rigs/marker_basis.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/rig_markers.h"

namespace risorius {

class FaceFit {
 public:
  FaceFit(const Rig& rig, const AuSolverOptions& options);

  MarkerBasis& basis() noexcept { return basis_; }
  const MarkerBasis& basis() const noexcept { return basis_; }
  AuPenalties& penalties() noexcept { return penalties_; }

  /// The weights (M) that most frames to come will have.
  void use_weights(const Eigen::VectorXd& usual) noexcept;
  void use_neutral(const Rig& rig) noexcept;
  /// A face at rest, and no active set to start from.
  void reset() noexcept;

  /// `upper` (K) 0 and `fixed` (K) the value for an AU that is not to be fitted; `penalties_changed` as
  /// AuPenalties::begin_frame says. All weights are those of the markers until the next fit.
  void begin_frame(const RigMarkers& markers, const Eigen::VectorXd& upper, const Eigen::VectorXd& fixed,
                   bool penalties_changed) noexcept;

  /// Those of the markers, or those that weigh_by_last_face left.
  enum class FirstWeights { kMarkers, kAtHand };
  /// Pose and intensities from this pose on, and the weights.
  void fit(const Rig& rig, const RigMarkers& markers, RigidTransform& world_from_head,
           FirstWeights first = FirstWeights::kMarkers) noexcept;
  /// Markers weigh less that are far from the face as fitted last. A first fit that a false marker bends can end with
  /// its neighbours given up instead of it.
  void weigh_by_last_face(const Rig& rig, const RigMarkers& markers, const RigidTransform& world_from_head) noexcept;
  /// The exact intensities at the pose and the weights of the last fit.
  QpResult certify() noexcept;
  /// All markers, as they are weighed now, against the face as fitted last.
  RigidAlignment align(const Rig& rig, const RigMarkers& markers) noexcept;

  const Eigen::VectorXd& x() const noexcept { return x_; }
  Eigen::VectorXd& x() noexcept { return x_; }
  const Eigen::VectorXd& weight() const noexcept { return weight_; }
  const Eigen::VectorXd& pulling_weight() const noexcept { return pulling_weight_; }
  /// The displacements of the fitted face, 3M.
  const Eigen::VectorXd& fitted_mm() const noexcept { return fitted_mm_; }
  /// Distance of each marker from the fitted face; M.
  std::span<const double> residual_mm() const noexcept { return residual_mm_; }
  double median_residual_mm(const RigMarkers& markers) noexcept;
  /// Of the measured ones alone; of all if there are none.
  double median_measured_residual_mm(const RigMarkers& markers) noexcept;
  /// By which fits in different poses are compared: residuals are cut off where markers are given up.
  double truncated_mean_square_mm2(const RigMarkers& markers) const noexcept;
  /// Per axis, over what the fit left free; at least the noise option, since few markers can be explained by chance.
  double noise_from_residuals_mm() const noexcept;
  /// Variances (K) of the last certified fit at unit noise; the pose may be wrong, too.
  void variances(Eigen::VectorXd& variance) noexcept;

 private:
  enum class Head { kStill, kCarriedAlong };
  QpResult fit_weighted(Head head, QpEffort effort) noexcept;
  bool renew_hessian(bool with_head) noexcept;
  void forget_hessians() noexcept;
  void project_markers(bool with_head) noexcept;
  void see_markers(const Rig& rig, const RigMarkers& markers) noexcept;
  void measure_residuals() noexcept;
  double left_to_move_mm(double step_mm) const noexcept;
  bool reweigh(const RigMarkers& markers, int iteration) noexcept;

  AuSolverOptions options_;
  MarkerBasis basis_;
  AuPenalties penalties_;
  PoseCoupling coupling_;
  BoundedQp qp_;
  Eigen::VectorXd pull_;         // M: by which a marker's weight counts where it fits
  Eigen::VectorXd earned_pull_;  // M: of the frame at work, 1 to pull_
  Eigen::VectorXd x_;            // K

  // Of the frame at work. M markers, K AUs.
  RigidTransform head_from_world_;
  Eigen::VectorXd weight_, pulling_weight_;           // M
  Eigen::VectorXd gram_weight_;                       // M: the weights that gram_ and reduced_ belong to
  bool gram_holds_ = false;                           // gram_ was made
  bool reduced_holds_ = false;                        // so was reduced_
  bool hessian_holds_ = false;                        // nothing in h_ has changed since it was made
  bool hessian_has_head_ = false;                     // h_ is from reduced_
  Eigen::VectorXd y_mm_, weighted_y_mm_, fitted_mm_;  // 3M
  std::vector<double> residual_mm_, scratch_;         // M
  std::vector<Eigen::Vector3d> head_mm_, world_mm_;   // M
  std::vector<double> pose_weight_;                   // M
  Eigen::VectorXd b_, upper_, fixed_, solution_;      // K
  Eigen::MatrixXd gram_, reduced_;                    // K x K: of the markers; with the head carried along
  Eigen::MatrixXd h_;                                 // K x K: one of the two and the penalties
};

}  // namespace risorius
