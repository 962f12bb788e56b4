#include "solve/au_solver.h"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "capture/check.h"
#include "capture/errors.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

/// The last frame's face is a good start for this one's pose only so long.
constexpr std::int64_t kRecentNs = 200'000'000;
/// A start that explains the markers so much worse than the last frame's solution, in squares, is not taken
/// unquestioned.
constexpr double kAcceptedGrowth = 1.5;

/// Over which the residuals' variance is averaged, and the most that it is believed to be.
constexpr double kResidualMemory_s = 1, kMostNoiseMm = 2;

/// A marker whose robust weight is less says nothing: it lies more than three thresholds off.
constexpr double kGivenUp = 0.01;

/// Of a worse median residual than this the cause is looked for.
constexpr double kSuspiciousMedianMm = 4;
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

Pose to_pose(const RigidTransform& t) noexcept {
  return {{t.rotation.x(), t.rotation.y(), t.rotation.z(), t.rotation.w()},
          {t.translation.x(), t.translation.y(), t.translation.z()}};
}

}  // namespace

AuSolver::AuSolver(Rig rig, const AuSolverOptions& options)
    : rig_(checked(std::move(rig))),
      options_(checked(options)),
      markers_(rig_, options_.noise_mm),
      stabiliser_pose_(rig_, options_.pose),
      mirror_check_(rig_),
      fit_(rig_, options_),
      au_set_id_(risorius::au_set_id(rig_.au_names())),
      seen_(rig_.au_count()),
      measured_weight_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rig_.marker_count()))),
      observed_(rig_.au_count()),
      follows_(rig_.au_count()) {
  for (Eigen::VectorXd* v : {&share_, &fixed_, &upper_, &variance_}) {
    *v = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rig_.au_count()));
  }
}

void AuSolver::use_marker_set(const MarkerSet& set) {
  markers_.use_marker_set(rig_, set);
  fit_.use_weights(markers_.present());
}

void AuSolver::set_neutral(const Eigen::Matrix3Xd& neutral_mm) {
  Rig renewed = rig_;
  renewed.neutral_mm = neutral_mm;
  rig_ = checked(std::move(renewed));
  fit_.use_neutral(rig_);
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
  fit_.reset();
  std::fill(seen_.begin(), seen_.end(), char{0});
  world_from_head_ = {};
  fit_.penalties().expect_residuals(options_.noise_mm * options_.noise_mm);
}

void AuSolver::solve(const MarkerFrame& frame, AuFrame& out) noexcept {
  out = AuFrame{};
  out.header = frame.header;
  out.header.set_id = au_set_id_;
  out.count = static_cast<std::uint32_t>(rig_.au_count());
  const double step_s = static_cast<double>(difference_ns(frame.header.capture_time_ns, last_time_ns_)) * 1e-9;
  markers_.read(frame);
  decide_observed();
  fit_.begin_frame(markers_, upper_, fixed_, begin_penalties(frame.header.capture_time_ns));
  if (!find_pose(frame.header.capture_time_ns)) {
    out.status = SolverStatus::kTooFewMarkers;
    out.world_from_head = to_pose(world_from_head_);
    std::fill(observed_.begin(), observed_.end(), char{0});
    publish_intensities(options_.noise_mm, false, out);
    return;
  }
  if (gives_up_aus()) {
    fit_.begin_frame(markers_, upper_, fixed_, false);
    fit();
  }
  if (fresh_) {  // what this face leaves unexplained is not known before it was fitted once
    learn_residuals(0);
    fit();
  }
  const QpResult qp = fit_.certify();
  last_cost_mm2_ = fit_.truncated_mean_square_mm2(markers_);
  publish(qp, out);
  if (!fresh_) learn_residuals(step_s);
  // From a face that is not the rig's there is nothing to go on.
  fresh_ = out.status == SolverStatus::kPoorFit || out.status == SolverStatus::kMirrored;
  last_time_ns_ = frame.header.capture_time_ns;
}

/// A good rig leaves its noise, a poor one some millimetres: by that the price of an intensity is set.
void AuSolver::learn_residuals(double step_s) noexcept {
  const double noise_mm = std::min(fit_.noise_from_residuals_mm(), kMostNoiseMm);
  const double renewed = fresh_ ? 1 : 1 - std::exp(-std::max(step_s, 0.0) / kResidualMemory_s);
  variance_mm2_ += renewed * (noise_mm * noise_mm - variance_mm2_);
  fit_.penalties().expect_residuals(variance_mm2_);
}

/// Finds the head and fits the AUs to it; false if the pose is not determined. Two starts: where the face of the last
/// frame lies best, if that is recent, for a face changes little from frame to frame; and, if that explains the markers
/// worse than the last frame was explained, as the stabilisers sit in the neutral. The better one is kept: few
/// stabilisers, and most of them on a moving brow, can agree on a wrong pose, but all markers together do not.
bool AuSolver::find_pose(std::int64_t capture_time_ns) noexcept {
  const std::int64_t step_ns = difference_ns(capture_time_ns, last_time_ns_);
  if (!stabiliser_pose_.is_possible(markers_) || !anything_measured()) return false;
  double cost = std::numeric_limits<double>::infinity();
  if (!fresh_ && step_ns > 0 && step_ns < kRecentNs && refine_pose()) {
    fit_.fit(rig_, markers_, world_from_head_, FaceFit::FirstWeights::kAtHand);
    cost = fit_.truncated_mean_square_mm2(markers_);
    if (cost <= kAcceptedGrowth * last_cost_mm2_) return true;
  }
  const RigidTransform of_last_face = world_from_head_;
  const HeadPoseResult of_stabilisers = stabiliser_pose_.estimate(rig_, markers_);
  if (!of_stabilisers.determined) return std::isfinite(cost);
  world_from_head_ = of_stabilisers.world_from_head;
  fit();
  if (fit_.truncated_mean_square_mm2(markers_) <= cost) return true;
  world_from_head_ = of_last_face;
  fit();
  return true;
}

/// Three markers, the least that hold a head: with fewer, all else is what the filler believes.
bool AuSolver::anything_measured() const noexcept {
  int measured = 0;
  for (std::size_t m = 0; m < rig_.marker_count(); ++m) measured += markers_.is_measured(m) ? 1 : 0;
  return measured >= 3;
}

bool AuSolver::refine_pose() noexcept {
  const RigidAlignment alignment = fit_.align(rig_, markers_);
  if (!alignment.determined) return false;
  world_from_head_ = alignment.to_from;
  fit_.weigh_by_last_face(rig_, markers_, world_from_head_);
  const RigidAlignment again = fit_.align(rig_, markers_);
  if (again.determined) world_from_head_ = again.to_from;
  fit_.weigh_by_last_face(rig_, markers_, world_from_head_);
  return true;
}

void AuSolver::decide_observed() noexcept {
  for (std::size_t m = 0; m < rig_.marker_count(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    measured_weight_[column] = markers_.is_measured(m) ? markers_.weight()[column] : 0;
  }
  fit_.basis().visible_share(measured_weight_, share_);
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    observed_[i] = share_[k] >= options_.min_visible_share;
    upper_[k] = observed_[i] ? rig_.aus[i].upper_bound : 0;
    fixed_[k] = observed_[i] ? 0 : fit_.x()[k];
  }
}

/// An AU that is seen only by markers which the fit has given up is not seen: it is taken back, and true returned. All
/// others keep what decide_observed said.
bool AuSolver::gives_up_aus() noexcept {
  bool gives_up_markers = false, gives_up = false;
  for (Eigen::Index m = 0; m < measured_weight_.size(); ++m) {
    if (!(measured_weight_[m] > 0) || fit_.weight()[m] >= kGivenUp * measured_weight_[m]) continue;
    measured_weight_[m] = 0;
    gives_up_markers = true;
  }
  if (!gives_up_markers) return false;
  fit_.basis().visible_share(measured_weight_, share_);
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!observed_[i] || share_[k] >= options_.min_visible_share) continue;
    observed_[i] = 0;
    upper_[k] = 0;
    fixed_[k] = fit_.penalties().previous()[k];
    gives_up = true;
  }
  return gives_up;
}

/// True if the penalties' Hessian is another than in the last frame.
bool AuSolver::begin_penalties(std::int64_t capture_time_ns) noexcept {
  const bool goes_on = !fresh_ && capture_time_ns > last_time_ns_;
  const double step_s = goes_on ? static_cast<double>(difference_ns(capture_time_ns, last_time_ns_)) * 1e-9 : 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) follows_[i] = seen_[i] && observed_[i];
  return fit_.penalties().begin_frame(follows_, fit_.x(), step_s);
}

void AuSolver::publish(const QpResult& qp, AuFrame& out) noexcept {
  // Filled markers lie where the last faces were: they must not vouch for this one.
  const double median_mm = fit_.median_measured_residual_mm(markers_);
  const bool mirrored = median_mm > kSuspiciousMedianMm && mirror_check_.looks_mirrored(rig_, markers_);
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
  for (std::size_t m = 0; m < rig_.marker_count(); ++m) {
    if (!markers_.is_measured(m)) continue;
    squared += fit_.residual_mm()[m] * fit_.residual_mm()[m];
    ++measured;
  }
  out.residual_rms_mm = measured > 0 ? std::sqrt(squared / measured) : 0;
  publish_intensities(fit_.noise_from_residuals_mm(), converged, out);
}

/// Where an AU is not fitted, nothing but its range is known: the standard deviation of a uniform distribution over it.
void AuSolver::publish_intensities(double noise_mm, bool converged, AuFrame& out) noexcept {
  if (converged) fit_.variances(variance_);
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double range = rig_.aus[i].upper_bound / std::sqrt(12.0);
    out.intensity[i] = fit_.x()[k];
    out.standard_deviation[i] = observed_[i] && converged ? std::min(noise_mm * std::sqrt(variance_[k]), range) : range;
    out.state[i] = observed_[i] ? AuState::kObserved : seen_[i] ? AuState::kHeld : AuState::kNotObserved;
    seen_[i] = seen_[i] || observed_[i];
  }
}

void AuSolver::predict_markers(Eigen::Matrix3Xd& world_mm) const noexcept {
  RISORIUS_CHECK(static_cast<std::size_t>(world_mm.cols()) == rig_.marker_count());
  for (Eigen::Index m = 0; m < world_mm.cols(); ++m) {
    world_mm.col(m) = world_from_head_ * Eigen::Vector3d(rig_.neutral_mm.col(m) + fit_.fitted_mm().segment<3>(3 * m));
  }
}

}  // namespace risorius
