#include "solve/face_fit.h"

#include <algorithm>
#include <cmath>

#include "solve/robust_weight.h"

namespace risorius {
namespace {

constexpr double kTruncateAtThresholds = 2;

/// In a refinement of the pose a stabiliser pulls so many times as hard as any other marker: AUs never explain all that
/// the others do, and what they leave must not turn the head.
constexpr double kStabiliserPull = 5;

/// As in head_pose.cpp: three standard deviations of a normal distribution, from its median.
constexpr double kMediansToThreshold = 3 * 1.4826;

}  // namespace

FaceFit::FaceFit(const Rig& rig, const AuSolverOptions& options)
    : options_(options),
      basis_(rig),
      penalties_(rig, options, basis_.mean_diagonal_mm2()),
      qp_(static_cast<int>(rig.au_count())) {
  const std::size_t markers = rig.marker_count();
  residual_mm_.resize(markers);
  scratch_.resize(markers);
  head_mm_.resize(markers, Eigen::Vector3d::Zero());
  world_mm_.resize(markers, Eigen::Vector3d::Zero());
  pose_weight_.resize(markers);
  const auto m_count = static_cast<Eigen::Index>(markers), k_count = static_cast<Eigen::Index>(rig.au_count());
  for (Eigen::VectorXd* v : {&weight_, &gram_weight_}) *v = Eigen::VectorXd::Zero(m_count);
  for (Eigen::VectorXd* v : {&y_mm_, &weighted_y_mm_, &fitted_mm_}) *v = Eigen::VectorXd::Zero(3 * m_count);
  for (Eigen::VectorXd* v : {&x_, &b_, &upper_, &fixed_, &solution_}) *v = Eigen::VectorXd::Zero(k_count);
  h_ = Eigen::MatrixXd::Zero(k_count, k_count);
}

void FaceFit::use_weights(const Eigen::VectorXd& usual) noexcept {
  gram_weight_ = usual;
  basis_.use_weights(gram_weight_);
  hessian_holds_ = false;
}

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
  if (penalties_changed) hessian_holds_ = false;
}

QpResult FaceFit::fit(const Rig& rig, const RigMarkers& markers, const RigidTransform& world_from_head,
                      QpEffort effort) noexcept {
  const RigidTransform head_from_world = world_from_head.inverse();
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    y_mm_.segment<3>(3 * m).setZero();
    if (!(markers.weight()[m] > 0)) continue;
    y_mm_.segment<3>(3 * m) = head_from_world * markers.world_mm(static_cast<std::size_t>(m)) - rig.neutral_mm.col(m);
  }
  weight_ = markers.weight();
  for (int iteration = 0;; ++iteration) {
    fit_weighted(QpEffort::kPrediction);
    measure_residuals();
    if (iteration == options_.robust_iterations || !reweigh(markers, iteration)) break;
  }
  if (effort == QpEffort::kPrediction) return {};
  const QpResult qp = fit_weighted(effort);
  measure_residuals();
  return qp;
}

QpResult FaceFit::fit_weighted(QpEffort effort) noexcept {
  const QpHessian hessian = renew_hessian() ? QpHessian::kNew : QpHessian::kSame;
  project_markers();
  const QpResult qp = qp_.solve(h_, b_, upper_, solution_, effort, hessian);
  x_ = solution_ + fixed_;
  basis_.deform(x_, fitted_mm_);
  return qp;
}

/// False if h_ is what it was.
bool FaceFit::renew_hessian() noexcept {
  if (hessian_holds_ && weight_ == gram_weight_) return false;
  basis_.gram(weight_, h_);
  gram_weight_ = weight_;
  hessian_holds_ = true;
  penalties_.add_to_hessian(h_);
  return true;
}

/// b_: the displacements that are seen, and the penalties, as the AUs to be fitted feel them.
void FaceFit::project_markers() noexcept {
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    weighted_y_mm_.segment<3>(3 * m) = weight_[m] * y_mm_.segment<3>(3 * m);
  }
  basis_.project(weighted_y_mm_, b_);
  penalties_.add_to_gradient(b_);
  if (!fixed_.isZero(0)) b_.noalias() -= h_ * fixed_;
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
    changed = changed || weight != weight_[column];
    weight_[column] = weight;
  }
  return changed;
}

RigidAlignment FaceFit::align(const Rig& rig, const RigMarkers& markers) noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    head_mm_[m] = rig.neutral_mm.col(column) + fitted_mm_.segment<3>(3 * column);
    world_mm_[m] = markers.world_mm(m);
    pose_weight_[m] = weight_[column] * (1 + kStabiliserPull * rig.stabiliser_weight[column]);
  }
  return align_rigid(head_mm_, world_mm_, pose_weight_);
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
