#include "solve/au_solver.h"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "capture/check.h"
#include "capture/errors.h"
#include "solve/rigs/au_name.h"
#include "solve/robust_weight.h"

namespace risorius {
namespace {

/// The last frame's face is a good start for this one's pose only so long.
constexpr std::int64_t kRecentNs = 200'000'000;
constexpr double kTruncateAtThresholds = 2;
/// A start that explains the markers so much worse than the last frame's solution, in squares, is not taken
/// unquestioned.
constexpr double kAcceptedGrowth = 1.5;

/// In a refinement of the pose a stabiliser pulls so many times as hard as any other marker: AUs never explain all that
/// the others do, and what they leave must not turn the head.
constexpr double kStabiliserPull = 5;

/// As in head_pose.cpp: three standard deviations of a normal distribution, from its median.
constexpr double kMediansToThreshold = 3 * 1.4826;
/// The time step at which the temporal penalty has its nominal weight, and the shortest one believed.
constexpr double kNominalStep_s = 1.0 / 60, kShortestStep_s = 1e-4;

/// Of a worse median residual than this the cause is looked for.
constexpr double kSuspiciousMedianMm = 4;
/// A mirror image fits better than the face by so much, in squares, only if the face is the mirror image.
constexpr double kMirrorGain = 4;

Rig checked(Rig rig) {
  if (const std::vector<std::string> problems = problems_of(rig); !problems.empty()) {
    throw UserError("rig '" + rig.name + "'", fmt::format("{}", fmt::join(problems, "; ")), "correct the rig");
  }
  return rig;
}

AuSolverOptions checked(const AuSolverOptions& options) {
  validate(options);
  return options;
}

std::vector<std::pair<int, int>> left_right_pairs(const Rig& rig) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    const auto left = parse_au_name(rig.aus[i].name);
    if (!left || left->side != AuSide::kLeft) continue;
    for (std::size_t j = 0; j < rig.au_count(); ++j) {
      if (rig.aus[j].name != format_au_name({left->number, AuSide::kRight})) continue;
      pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  }
  return pairs;
}

Pose to_pose(const RigidTransform& t) noexcept {
  return {{t.rotation.x(), t.rotation.y(), t.rotation.z(), t.rotation.w()},
          {t.translation.x(), t.translation.y(), t.translation.z()}};
}

}  // namespace

AuSolver::AuSolver(Rig rig, const AuSolverOptions& options)
    : rig_(checked(std::move(rig))),
      options_(checked(options)),
      markers_(rig_, options_.noise_mm),
      basis_(rig_),
      head_pose_(rig_.marker_count(), options_.pose),
      qp_(static_cast<int>(rig_.au_count())),
      au_set_id_(risorius::au_set_id(rig_.au_names())),
      left_right_pairs_(left_right_pairs(rig_)) {
  const std::size_t markers = rig_.marker_count(), aus = rig_.au_count();
  for (std::size_t m = 0; m < markers; ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    if (!(rig_.stabiliser_weight[column] > 0)) continue;
    stabilisers_.push_back(static_cast<int>(m));
  }
  stabiliser_head_mm_.resize(stabilisers_.size());
  stabiliser_world_mm_.resize(stabilisers_.size());
  stabiliser_weight_.resize(stabilisers_.size());
  seen_.resize(aus);
  observed_.resize(aus);
  residual_mm_.resize(markers);
  fitted_head_mm_.resize(markers, Eigen::Vector3d::Zero());
  seen_world_mm_.resize(markers, Eigen::Vector3d::Zero());
  pose_weight_.resize(markers);
  scratch_.resize(markers);
  const auto m_count = static_cast<Eigen::Index>(markers), k_count = static_cast<Eigen::Index>(aus);
  for (Eigen::VectorXd* v : {&weight_, &measured_weight_, &gram_weight_}) *v = Eigen::VectorXd::Zero(m_count);
  for (Eigen::VectorXd* v : {&y_mm_, &weighted_y_mm_, &fitted_mm_}) *v = Eigen::VectorXd::Zero(3 * m_count);
  for (Eigen::VectorXd* v :
       {&x_, &share_, &b_fit_, &fixed_, &upper_, &solution_, &variance_, &temporal_, &previous_x_}) {
    *v = Eigen::VectorXd::Zero(k_count);
  }
  h_ = Eigen::MatrixXd::Zero(k_count, k_count);
}

void AuSolver::use_marker_set(const MarkerSet& set) {
  markers_.use_marker_set(rig_, set);
  gram_weight_ = markers_.present();
  basis_.use_weights(gram_weight_);
  hessian_holds_ = false;
}

void AuSolver::set_neutral(const Eigen::Matrix3Xd& neutral_mm) {
  Rig renewed = rig_;
  renewed.neutral_mm = neutral_mm;
  rig_ = checked(std::move(renewed));
}

bool AuSolver::push(const MarkerFrame& frame) noexcept {
  if (has_out_) return false;
  ledger_.received.add();
  if (!markers_.accepts(frame)) {
    ledger_.refused.add();
    return true;
  }
  if (fresh_) start_take();
  solve(frame, out_);
  has_out_ = true;
  ledger_.held.set(1);
  return true;
}

bool AuSolver::pop(AuFrame& frame) noexcept {
  if (!has_out_) return false;
  frame = out_;
  has_out_ = false;
  ledger_.held.set(0);
  ledger_.emitted.add();
  return true;
}

void AuSolver::start_take() noexcept {
  x_.setZero();
  fitted_mm_.setZero();
  std::fill(seen_.begin(), seen_.end(), char{0});
  world_from_head_ = {};
  qp_.reset();
}

void AuSolver::solve(const MarkerFrame& frame, AuFrame& out) noexcept {
  out = AuFrame{};
  out.header = frame.header;
  out.header.set_id = au_set_id_;
  out.count = static_cast<std::uint32_t>(rig_.au_count());
  markers_.read(frame);
  decide_observed();
  prepare_penalties(frame.header.capture_time_ns);
  if (!find_pose(frame.header.capture_time_ns)) {
    out.status = SolverStatus::kTooFewMarkers;
    out.world_from_head = to_pose(world_from_head_);
    std::fill(observed_.begin(), observed_.end(), char{0});
    publish_intensities(options_.noise_mm, false, out);
    return;
  }
  // Only the last fit is published, so only that one must be exact.
  for (int refinement = 0; refinement < options_.pose_refinements; ++refinement) {
    refine_pose();
    if (refinement + 1 < options_.pose_refinements) fit(QpEffort::kPrediction);
  }
  const QpResult qp = fit(QpEffort::kExact);
  last_cost_mm2_ = truncated_mean_square_mm2();
  publish(qp, out);
  // From a face that is not the rig's there is nothing to go on.
  fresh_ = out.status == SolverStatus::kPoorFit || out.status == SolverStatus::kMirrored;
  last_time_ns_ = frame.header.capture_time_ns;
}

/// Finds the head and fits the AUs to it; false if the pose is not determined. Two starts: where the face of the last
/// frame lies best, if that is recent, for a face changes little from frame to frame; and, if that explains the markers
/// worse than the last frame was explained, as the stabilisers sit in the neutral. The better one is kept: few
/// stabilisers, and most of them on a moving brow, can agree on a wrong pose, but all markers together do not.
bool AuSolver::find_pose(std::int64_t capture_time_ns) noexcept {
  const std::int64_t step_ns = difference_ns(capture_time_ns, last_time_ns_);
  weight_ = markers_.weight();
  if (!stabilisers_visible() || !anything_measured()) return false;
  double cost = std::numeric_limits<double>::infinity();
  if (!fresh_ && step_ns > 0 && step_ns < kRecentNs && refine_pose()) {
    fit(QpEffort::kPrediction);
    cost = truncated_mean_square_mm2();
    if (cost <= kAcceptedGrowth * last_cost_mm2_) return true;
  }
  const RigidTransform of_last_face = world_from_head_;
  const HeadPoseResult of_stabilisers = stabiliser_pose();
  if (!of_stabilisers.determined) return std::isfinite(cost);
  world_from_head_ = of_stabilisers.world_from_head;
  fit(QpEffort::kPrediction);
  if (truncated_mean_square_mm2() <= cost) return true;
  world_from_head_ = of_last_face;
  fit(QpEffort::kPrediction);
  return true;
}

HeadPoseResult AuSolver::stabiliser_pose() noexcept {
  for (std::size_t s = 0; s < stabilisers_.size(); ++s) {
    const auto m = static_cast<Eigen::Index>(stabilisers_[s]);
    stabiliser_head_mm_[s] = rig_.neutral_mm.col(m);
    stabiliser_world_mm_[s] = markers_.world_mm(static_cast<std::size_t>(m));
    stabiliser_weight_[s] = rig_.stabiliser_weight[m] * markers_.weight()[m];
  }
  return head_pose_.estimate(stabiliser_head_mm_, stabiliser_world_mm_, stabiliser_weight_);
}

double AuSolver::truncated_mean_square_mm2() const noexcept {
  const double most = kTruncateAtThresholds * options_.robust_threshold_mm;
  double sum = 0, weights = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const double weight = markers_.weight()[static_cast<Eigen::Index>(m)];
    const double distance = std::min(residual_mm_[m], most);
    sum += weight * distance * distance;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

bool AuSolver::stabilisers_visible() const noexcept {
  int visible = 0;
  for (const int m : stabilisers_) visible += markers_.weight()[m] > 0 ? 1 : 0;
  return visible >= 3;
}

/// Three markers, the least that hold a head: with fewer, all else is what the filler believes.
bool AuSolver::anything_measured() const noexcept {
  int measured = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) measured += markers_.is_measured(m) ? 1 : 0;
  return measured >= 3;
}

/// The other half of a joint fit: all markers, as the fit just weighed them, against the fitted face. Pose and AUs in
/// turn lower one and the same sum of squares.
bool AuSolver::refine_pose() noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    fitted_head_mm_[m] = rig_.neutral_mm.col(column) + fitted_mm_.segment<3>(3 * column);
    seen_world_mm_[m] = markers_.world_mm(m);
    pose_weight_[m] = weight_[column] * (1 + kStabiliserPull * rig_.stabiliser_weight[column]);
  }
  const RigidAlignment alignment = align_rigid(fitted_head_mm_, seen_world_mm_, pose_weight_);
  if (alignment.determined) world_from_head_ = alignment.to_from;
  return alignment.determined;
}

void AuSolver::decide_observed() noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    measured_weight_[column] = markers_.is_measured(m) ? markers_.weight()[column] : 0;
  }
  basis_.visible_share(measured_weight_, share_);
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    observed_[i] = share_[k] >= options_.min_visible_share;
    upper_[k] = observed_[i] ? rig_.aus[i].upper_bound : 0;
    fixed_[k] = observed_[i] ? 0 : x_[k];
  }
}

/// temporal_ becomes the weight by which each AU is drawn to x_ of the last frame.
void AuSolver::prepare_penalties(std::int64_t capture_time_ns) noexcept {
  const double step_s = static_cast<double>(difference_ns(capture_time_ns, last_time_ns_)) * 1e-9;
  const bool follows = !fresh_ && capture_time_ns > last_time_ns_;
  const double weight = follows ? options_.temporal * kNominalStep_s / std::max(step_s, kShortestStep_s) : 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double temporal = seen_[i] && observed_[i] ? weight * basis_.mean_diagonal_mm2() : 0;
    hessian_holds_ = hessian_holds_ && temporal == temporal_[k];
    temporal_[k] = temporal;
  }
  previous_x_ = x_;
}

QpResult AuSolver::fit(QpEffort effort) noexcept {
  const RigidTransform head_from_world = world_from_head_.inverse();
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    y_mm_.segment<3>(3 * m).setZero();
    if (!(markers_.weight()[m] > 0)) continue;
    y_mm_.segment<3>(3 * m) = head_from_world * markers_.world_mm(static_cast<std::size_t>(m)) - rig_.neutral_mm.col(m);
  }
  weight_ = markers_.weight();
  for (int iteration = 0;; ++iteration) {
    fit_weighted(QpEffort::kPrediction);
    measure_residuals();
    if (iteration == options_.robust_iterations || !reweigh(iteration)) break;
  }
  if (effort == QpEffort::kPrediction) return {};
  const QpResult qp = fit_weighted(effort);
  measure_residuals();
  return qp;
}

QpResult AuSolver::fit_weighted(QpEffort effort) noexcept {
  const QpHessian hessian = renew_hessian() ? QpHessian::kNew : QpHessian::kSame;
  project_markers();
  const QpResult qp = qp_.solve(h_, b_fit_, upper_, solution_, effort, hessian);
  x_ = solution_ + fixed_;
  basis_.deform(x_, fitted_mm_);
  return qp;
}

/// False if h_ is what it was.
bool AuSolver::renew_hessian() noexcept {
  if (hessian_holds_ && weight_ == gram_weight_) return false;
  basis_.gram(weight_, h_);
  gram_weight_ = weight_;
  hessian_holds_ = true;
  const double unit = basis_.mean_diagonal_mm2();
  h_.diagonal().array() += options_.ridge * unit + temporal_.array();
  const double tie = options_.left_right * unit;
  for (const auto& [left, right] : left_right_pairs_) {
    h_(left, left) += tie;
    h_(right, right) += tie;
    h_(left, right) -= tie;
    h_(right, left) -= tie;
  }
  return true;
}

/// b_fit_: the displacements that are seen, and the penalties, as the AUs to be fitted feel them.
void AuSolver::project_markers() noexcept {
  for (Eigen::Index m = 0; m < basis_.marker_count(); ++m) {
    weighted_y_mm_.segment<3>(3 * m) = weight_[m] * y_mm_.segment<3>(3 * m);
  }
  basis_.project(weighted_y_mm_, b_fit_);
  b_fit_.array() += temporal_.array() * previous_x_.array() - options_.l1 * basis_.mean_diagonal_mm2();
  if (!fixed_.isZero(0)) b_fit_.noalias() -= h_ * fixed_;
}

void AuSolver::measure_residuals() noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto row = static_cast<Eigen::Index>(3 * m);
    residual_mm_[m] = (fitted_mm_.segment<3>(row) - y_mm_.segment<3>(row)).norm();
  }
}

double AuSolver::median_residual_mm() noexcept {
  std::size_t used = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    if (markers_.weight()[static_cast<Eigen::Index>(m)] > 0) scratch_[used++] = residual_mm_[m];
  }
  return lower_median(std::span(scratch_).first(used));
}

/// False if no weight changed.
bool AuSolver::reweigh(int iteration) noexcept {
  const double threshold = std::max(options_.robust_threshold_mm, kMediansToThreshold * median_residual_mm());
  bool changed = false;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    const double weight =
        markers_.weight()[column] * robust_weight(residual_mm_[m], threshold, robust_power(iteration));
    changed = changed || weight != weight_[column];
    weight_[column] = weight;
  }
  return changed;
}

/// Faces are nearly symmetric, so that a mirrored one is not far from any rig; but its mirror image is much nearer.
bool AuSolver::looks_mirrored() noexcept {
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    fitted_head_mm_[m] = rig_.neutral_mm.col(column);
    seen_world_mm_[m] = markers_.world_mm(m);
    pose_weight_[m] = markers_.weight()[column];
  }
  const auto mean_square = [&] {
    const RigidAlignment fit = align_rigid(fitted_head_mm_, seen_world_mm_, pose_weight_);
    double sum = 0;
    for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
      sum += pose_weight_[m] * (fit.to_from * fitted_head_mm_[m] - seen_world_mm_[m]).squaredNorm();
    }
    return fit.determined ? sum : std::numeric_limits<double>::infinity();
  };
  const double as_seen = mean_square();
  for (Eigen::Vector3d& p : seen_world_mm_) p.x() = -p.x();
  return kMirrorGain * mean_square() < as_seen;
}

void AuSolver::publish(const QpResult& qp, AuFrame& out) noexcept {
  const double median_mm = median_residual_mm();
  const bool mirrored = median_mm > kSuspiciousMedianMm && looks_mirrored();
  const bool fits = median_mm <= options_.largest_median_mm && !mirrored;
  const bool converged = fits && qp.status == QpStatus::kConverged;
  out.status = mirrored    ? SolverStatus::kMirrored
               : !fits     ? SolverStatus::kPoorFit
               : converged ? SolverStatus::kConverged
                           : SolverStatus::kIterationLimit;
  if (!fits) std::fill(observed_.begin(), observed_.end(), char{0});
  out.kkt_residual = qp.kkt_residual;
  out.world_from_head = to_pose(world_from_head_);
  double squared = 0;
  int measured = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    if (!markers_.is_measured(m)) continue;
    squared += residual_mm_[m] * residual_mm_[m];
    ++measured;
  }
  out.residual_rms_mm = measured > 0 ? std::sqrt(squared / measured) : 0;
  publish_intensities(noise_from_residuals(), converged, out);
}

/// Where an AU is not fitted, nothing but its range is known: the standard deviation of a uniform distribution over it.
void AuSolver::publish_intensities(double noise_mm, bool converged, AuFrame& out) noexcept {
  if (converged) qp_.inverse_diagonal(h_, variance_);
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double range = rig_.aus[i].upper_bound / std::sqrt(12.0);
    out.intensity[i] = x_[k];
    out.standard_deviation[i] = observed_[i] && converged ? std::min(noise_mm * std::sqrt(variance_[k]), range) : range;
    out.state[i] = observed_[i] ? AuState::kObserved : seen_[i] ? AuState::kHeld : AuState::kNotObserved;
    seen_[i] = seen_[i] || observed_[i];
  }
}

/// Per axis, over what the fit left free; at least the noise option, since few markers can be explained by chance.
double AuSolver::noise_from_residuals() const noexcept {
  double squared = 0, axes = 0;
  for (std::size_t m = 0; m < residual_mm_.size(); ++m) {
    const double weight = weight_[static_cast<Eigen::Index>(m)];
    squared += weight * residual_mm_[m] * residual_mm_[m];
    axes += 3 * weight;
  }
  for (std::size_t i = 0; i < rig_.au_count(); ++i) axes -= qp_.is_free(static_cast<int>(i));
  return axes > 1 ? std::max(options_.noise_mm, std::sqrt(squared / axes)) : options_.noise_mm;
}

void AuSolver::predict_markers(Eigen::Matrix3Xd& world_mm) const noexcept {
  RISORIUS_CHECK(world_mm.cols() == basis_.marker_count());
  for (Eigen::Index m = 0; m < world_mm.cols(); ++m) {
    world_mm.col(m) = world_from_head_ * Eigen::Vector3d(rig_.neutral_mm.col(m) + fitted_mm_.segment<3>(3 * m));
  }
}

}  // namespace risorius
