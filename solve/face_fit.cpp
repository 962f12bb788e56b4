#include "solve/face_fit.h"

#include <algorithm>
#include <cmath>

#include "solve/robust_weight.h"

namespace risorius {
namespace {

constexpr double kTruncateAtThresholds = 2;

/// By so many times a stabiliser pulls harder than any other marker: AUs never explain all that the others do, and what
/// they leave must not turn the head.
constexpr double kStabiliserPull = 5;
/// Unlike a marker's weight it falls beyond the option's own threshold, wherever the median lies: a stabiliser that
/// moves with the brows, or is false, counts as any other marker.
constexpr int kPullPower = 2;
/// A joint step that leaves the head this near to where it belongs is the last: a hundredth of a marker's noise.
constexpr double kStill_mm = 2e-3;

/// As in head_pose.cpp: three standard deviations of a normal distribution, from its median.
constexpr double kMediansToThreshold = 3 * 1.4826;
constexpr int kFirstIteration = 1;  // a false marker weighs little from the start, and none is lost for good

}  // namespace

FaceFit::FaceFit(const Rig& rig, const AuSolverOptions& options)
    : options_(options),
      basis_(rig),
      penalties_(rig, options, basis_.mean_diagonal_mm2()),
      coupling_(rig),
      qp_(static_cast<int>(rig.au_count())),
      pull_(1 + kStabiliserPull * rig.stabiliser_weight.array()),
      earned_pull_(pull_) {
  const std::size_t markers = rig.marker_count();
  residual_mm_.resize(markers);
  scratch_.resize(markers);
  head_mm_.resize(markers, Eigen::Vector3d::Zero());
  world_mm_.resize(markers, Eigen::Vector3d::Zero());
  pose_weight_.resize(markers);
  const auto m_count = static_cast<Eigen::Index>(markers), k_count = static_cast<Eigen::Index>(rig.au_count());
  for (Eigen::VectorXd* v : {&weight_, &pulling_weight_, &gram_weight_}) *v = Eigen::VectorXd::Zero(m_count);
  for (Eigen::VectorXd* v : {&y_mm_, &weighted_y_mm_, &fitted_mm_}) *v = Eigen::VectorXd::Zero(3 * m_count);
  for (Eigen::VectorXd* v : {&x_, &b_, &upper_, &fixed_, &solution_}) *v = Eigen::VectorXd::Zero(k_count);
  for (Eigen::MatrixXd* h : {&gram_, &reduced_, &h_}) *h = Eigen::MatrixXd::Zero(k_count, k_count);
}

void FaceFit::use_weights(const Eigen::VectorXd& usual) noexcept {
  const Eigen::VectorXd pulling = usual.cwiseProduct(pull_);
  basis_.use_weights(pulling);
  coupling_.use_weights(pulling);
  forget_hessians();
}

void FaceFit::use_neutral(const Rig& rig) noexcept {
  coupling_.use_neutral(rig);
  forget_hessians();
}

void FaceFit::forget_hessians() noexcept { gram_holds_ = reduced_holds_ = hessian_holds_ = false; }

void FaceFit::reset() noexcept {
  x_.setZero();
  fitted_mm_.setZero();
  qp_.reset();
}

void FaceFit::begin_frame(const RigMarkers& markers, const Eigen::VectorXd& upper, const Eigen::VectorXd& fixed,
                          bool penalties_changed) noexcept {
  upper_ = upper;
  fixed_ = fixed;
  weight_ = markers.weight();
  earned_pull_ = pull_;
  if (penalties_changed) hessian_holds_ = false;
}

void FaceFit::weigh_by_last_face(const Rig& rig, const RigMarkers& markers,
                                 const RigidTransform& world_from_head) noexcept {
  head_from_world_ = world_from_head.inverse();
  see_markers(rig, markers);
  measure_residuals();
  if (options_.robust_iterations > 0) reweigh(markers, kFirstIteration);
}

void FaceFit::fit(const Rig& rig, const RigMarkers& markers, RigidTransform& world_from_head,
                  FirstWeights first) noexcept {
  head_from_world_ = world_from_head.inverse();
  if (first == FirstWeights::kMarkers) {
    weight_ = markers.weight();
    earned_pull_ = pull_;
  }
  see_markers(rig, markers);
  const int steps = std::max(options_.robust_iterations, options_.pose_steps);
  for (int step = 0;; ++step) {
    const bool carries = step < options_.pose_steps;
    fit_weighted(carries ? Head::kCarriedAlong : Head::kStill, QpEffort::kPrediction);
    const bool moved =
        carries && hessian_has_head_ && left_to_move_mm(coupling_.move_head(x_, head_from_world_)) > kStill_mm;
    if (carries) see_markers(rig, markers);
    measure_residuals();
    const bool weighed = step < options_.robust_iterations && reweigh(markers, step);
    if (step >= steps || (!moved && !weighed)) break;
  }
  world_from_head = head_from_world_.inverse();
}

/// What a step of the head by `step_mm` leaves to the next one: it was linear, and made at the neutral face instead of
/// the one that is there.
double FaceFit::left_to_move_mm(double step_mm) const noexcept {
  const double off_neutral_mm = fitted_mm_.norm() / std::sqrt(static_cast<double>(basis_.marker_count()));
  return step_mm * (step_mm + off_neutral_mm) / coupling_.radius_mm();
}

QpResult FaceFit::certify() noexcept {
  const QpResult qp = fit_weighted(Head::kStill, QpEffort::kExact);
  measure_residuals();
  return qp;
}

QpResult FaceFit::fit_weighted(Head head, QpEffort effort) noexcept {
  pulling_weight_ = weight_.cwiseProduct(earned_pull_);
  const bool with_head = head == Head::kCarriedAlong && coupling_.prepare(pulling_weight_);
  const QpHessian hessian = renew_hessian(with_head) ? QpHessian::kNew : QpHessian::kSame;
  project_markers(with_head);
  const QpResult qp = qp_.solve(h_, b_, upper_, solution_, effort, hessian);
  x_ = solution_ + fixed_;
  basis_.deform(x_, fitted_mm_);
  return qp;
}

/// False if h_ is what it was.
bool FaceFit::renew_hessian(bool with_head) noexcept {
  if (!gram_holds_ || pulling_weight_ != gram_weight_) {
    basis_.gram(pulling_weight_, gram_);
    gram_weight_ = pulling_weight_;
    gram_holds_ = true;
    reduced_holds_ = hessian_holds_ = false;
  }
  if (with_head && !reduced_holds_) {
    reduced_ = gram_;
    coupling_.reduce_hessian(reduced_);
    reduced_holds_ = true;
  }
  if (hessian_holds_ && hessian_has_head_ == with_head) return false;
  h_ = with_head ? reduced_ : gram_;
  hessian_holds_ = true;
  hessian_has_head_ = with_head;
  penalties_.add_to_hessian(h_);
  return true;
}

/// b_: the displacements that are seen, and the penalties, as the AUs to be fitted feel them.
void FaceFit::project_markers(bool with_head) noexcept {
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    weighted_y_mm_.segment<3>(3 * m) = pulling_weight_[m] * y_mm_.segment<3>(3 * m);
  }
  basis_.project(weighted_y_mm_, b_);
  if (with_head) {
    coupling_.project(weighted_y_mm_);
    coupling_.reduce_gradient(b_);
  }
  penalties_.add_to_gradient(b_);
  if (!fixed_.isZero(0)) b_.noalias() -= h_ * fixed_;
}

/// y_mm_ in the pose at hand; 0 where nothing is seen.
void FaceFit::see_markers(const Rig& rig, const RigMarkers& markers) noexcept {
  const Eigen::Matrix3d rotation = head_from_world_.rotation.toRotationMatrix();
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    if (markers.weight()[m] > 0) {
      y_mm_.segment<3>(3 * m) = rotation * markers.world_mm(static_cast<std::size_t>(m)) +
                                head_from_world_.translation - rig.neutral_mm.col(m);
    } else {
      y_mm_.segment<3>(3 * m).setZero();
    }
  }
}

void FaceFit::variances(Eigen::VectorXd& variance) noexcept {
  if (coupling_.prepare(pulling_weight_)) renew_hessian(true);
  qp_.inverse_diagonal(h_, variance);
}

void FaceFit::measure_residuals() noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto row = static_cast<Eigen::Index>(3 * m);
    residual_mm_[m] = (fitted_mm_.segment<3>(row) - y_mm_.segment<3>(row)).norm();
  }
}

/// False if no weight changed.
bool FaceFit::reweigh(const RigMarkers& markers, int iteration) noexcept {
  const double threshold = std::max(options_.robust_threshold_mm, kMediansToThreshold * median_residual_mm(markers));
  bool changed = false;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    const double weight = markers.weight()[column] * robust_weight(residual_mm_[m], threshold, robust_power(iteration));
    const double pull =
        1 + (pull_[column] - 1) * robust_weight(residual_mm_[m], options_.robust_threshold_mm, kPullPower);
    changed = changed || weight != weight_[column] || pull != earned_pull_[column];
    weight_[column] = weight;
    earned_pull_[column] = pull;
  }
  return changed;
}

RigidAlignment FaceFit::align(const Rig& rig, const RigMarkers& markers) noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    head_mm_[m] = rig.neutral_mm.col(column) + fitted_mm_.segment<3>(3 * column);
    world_mm_[m] = markers.world_mm(m);
    pose_weight_[m] = weight_[column] * earned_pull_[column];
  }
  return align_rigid(head_mm_, world_mm_, pose_weight_);
}

double FaceFit::median_measured_residual_mm(const RigMarkers& markers) noexcept {
  std::size_t used = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    if (markers.is_measured(m)) scratch_[used++] = residual_mm_[m];
  }
  return used > 0 ? lower_median(std::span(scratch_).first(used)) : median_residual_mm(markers);
}

double FaceFit::median_residual_mm(const RigMarkers& markers) noexcept {
  std::size_t used = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    if (markers.weight()[static_cast<Eigen::Index>(m)] > 0) scratch_[used++] = residual_mm_[m];
  }
  return lower_median(std::span(scratch_).first(used));
}

double FaceFit::truncated_mean_square_mm2(const RigMarkers& markers) const noexcept {
  const double most = kTruncateAtThresholds * options_.robust_threshold_mm;
  double sum = 0, weights = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const double weight = markers.weight()[static_cast<Eigen::Index>(m)];
    const double distance = std::min(residual_mm_[m], most);
    sum += weight * distance * distance;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

double FaceFit::noise_from_residuals_mm() const noexcept {
  double squared = 0, axes = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const double weight = weight_[static_cast<Eigen::Index>(m)];
    squared += weight * residual_mm_[m] * residual_mm_[m];
    axes += 3 * weight;
  }
  for (Eigen::Index i = 0; i < x_.size(); ++i) axes -= qp_.is_free(static_cast<int>(i));
  return axes > 1 ? std::max(options_.noise_mm, std::sqrt(squared / axes)) : options_.noise_mm;
}

}  // namespace risorius
