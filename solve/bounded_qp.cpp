#include "solve/bounded_qp.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "capture/check.h"
#include "capture/frames.h"

namespace risorius {
namespace {

constexpr double kTolerance = 1e-12;  // relative to the larger of 1 and ||D^-1 b||_inf
constexpr int kMaxRefinements = 3;
constexpr int kPatience = 3;  // block exchanges that may fail to reduce the number of violators
constexpr int kMaxBlockExchanges = 40;
constexpr int kReleasesBeforeBland = 64;
constexpr int kMaxFallbackSolves = 4096;

int checked_size(int size) {
  if (size < 1 || size > static_cast<int>(kMaxAus)) {
    throw std::invalid_argument("BoundedQp size " + std::to_string(size) + " is not in 1 to " +
                                std::to_string(kMaxAus));
  }
  return size;
}

}  // namespace

BoundedQp::BoundedQp(int size)
    : size_(checked_size(size)),
      free_set_(size),
      place_(size, Place::kLower),
      c_free_(size),
      x_free_(size),
      x_(Eigen::VectorXd::Zero(size)),
      gradient_(Eigen::VectorXd::Zero(size)),
      feasible_(Eigen::VectorXd::Zero(size)) {
  free_.reserve(size);
  factored_.reserve(size);
}

void BoundedQp::reset() noexcept { std::fill(place_.begin(), place_.end(), Place::kLower); }

QpResult BoundedQp::solve(const Eigen::MatrixXd& h, const Eigen::VectorXd& b, const Eigen::VectorXd& upper,
                          Eigen::VectorXd& x, QpEffort effort, QpHessian hessian) noexcept {
  RISORIUS_CHECK(h.rows() == size_ && h.cols() == size_ && b.size() == size_ && upper.size() == size_ &&
                 x.size() == size_);
  if (hessian == QpHessian::kNew) factor_holds_ = false;
  double largest = 1;
  for (int i = 0; i < size_; ++i) {
    largest = std::max(largest, std::abs(b[i]) / h(i, i));
    if (!(upper[i] > 0)) place_[i] = Place::kLower;
  }
  const Problem problem{h, b, upper, kTolerance * largest};
  QpResult result;
  const bool settled = !force_fallback_ && pivot_blocks(problem, result);
  if (!settled) descend_feasibly(problem, result);
  // Should the last digits of Ceres's solution offend where the prediction's did not, the exact descent decides.
  if (effort == QpEffort::kExact && !result.used_fallback && !settle_with_ceres(problem)) {
    descend_feasibly(problem, result);
  }
  move_inside_bounds(problem);
  result.kkt_residual = kkt_residual(problem);
  x = x_;
  return result;
}

/// False if H is not positive definite on the variables that are free now. x_ gets the others, at their bounds.
bool BoundedQp::factor_free_set(const Problem& problem) noexcept {
  free_.clear();
  for (int i = 0; i < size_; ++i) {
    x_[i] = place_[i] == Place::kUpper ? problem.upper[i] : 0;
    if (place_[i] == Place::kFree) free_.push_back(i);
  }
  if (factor_holds_ && free_ == factored_) return true;
  factored_ = free_;
  factor_holds_ = free_set_.factor(problem.h, free_);
  return factor_holds_;
}

/// x_ becomes the minimum over the free variables with the others at their bounds; gradient_ belongs to it.
void BoundedQp::minimise_on_free_set(const Problem& problem, Method method) noexcept {
  for (const int i : free_) x_[i] = 0;
  update_gradient(problem);
  if (free_.empty()) return;
  const std::span<double> c = std::span(c_free_).first(free_.size());
  const std::span<double> step = std::span(x_free_).first(free_.size());
  for (int round = 0; round <= kMaxRefinements; ++round) {
    double largest = 0;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      c[k] = -gradient_[free_[k]];
      largest = std::max(largest, std::abs(c[k]) / problem.h(free_[k], free_[k]));
    }
    if (round > 0 && largest <= problem.tolerance) break;
    // The first step is the solution; further ones only take away its rounding.
    if (method == Method::kCeres && round == 0) {
      free_set_.solve(c, step);
    } else {
      free_set_.predict(c, step);
    }
    for (std::size_t k = 0; k < free_.size(); ++k) x_[free_[k]] += step[k];
    update_gradient(problem);
  }
}

/// Solves once more, with Ceres, on the free set that is factored; false if that changes who offends.
bool BoundedQp::settle_with_ceres(const Problem& problem) noexcept {
  minimise_on_free_set(problem, Method::kCeres);
  return exchange_violators(problem, false) == 0;
}

void BoundedQp::update_gradient(const Problem& problem) noexcept {
  gradient_ = -problem.b;
  gradient_.noalias() += problem.h * x_;
}

/// By how much variable i offends against optimality, in units of x; 0 if it does not.
double BoundedQp::violation(const Problem& problem, int i) const noexcept {
  if (!(problem.upper[i] > 0)) return 0;
  const double downhill = -gradient_[i] / problem.h(i, i);
  double offence = 0;
  switch (place_[i]) {
    case Place::kFree:
      offence = std::max(-x_[i], x_[i] - problem.upper[i]);
      break;
    case Place::kLower:
      offence = downhill;
      break;
    case Place::kUpper:
      offence = -downhill;
      break;
  }
  return offence > problem.tolerance ? offence : 0;
}

/// Counts the violators and, if asked, moves each to where it strives.
int BoundedQp::exchange_violators(const Problem& problem, bool exchange) noexcept {
  int violators = 0;
  for (int i = 0; i < size_; ++i) {
    if (!(violation(problem, i) > 0)) continue;
    ++violators;
    if (!exchange) continue;
    const bool was_free = place_[i] == Place::kFree;
    place_[i] = !was_free ? Place::kFree : x_[i] < 0 ? Place::kLower : Place::kUpper;
  }
  return violators;
}

/// False where it does not settle.
bool BoundedQp::pivot_blocks(const Problem& problem, QpResult& result) noexcept {
  int fewest = size_ + 1, patience = kPatience;
  for (int exchange = 0; exchange < kMaxBlockExchanges; ++exchange) {
    ++result.free_set_solves;
    if (!factor_free_set(problem)) return false;
    minimise_on_free_set(problem, Method::kPredict);
    const int violators = exchange_violators(problem, false);
    if (violators == 0) return true;
    if (violators < fewest) {
      fewest = violators;
      patience = kPatience;
    } else if (patience-- == 0) {
      return false;
    }
    exchange_violators(problem, true);
  }
  return false;
}

/// Primal active-set method: every iterate is feasible and the objective never rises. Each free set's minimum is
/// unique, so no set that lowered the objective comes back; Bland's rule keeps steps of length zero from cycling.
void BoundedQp::descend_feasibly(const Problem& problem, QpResult& result) noexcept {
  result.used_fallback = true;
  for (int i = 0; i < size_; ++i) {
    feasible_[i] = std::isfinite(x_[i]) ? std::clamp(x_[i], 0.0, problem.upper[i]) : 0;
    const bool inside = feasible_[i] > 0 && feasible_[i] < problem.upper[i];
    place_[i] = inside ? Place::kFree : feasible_[i] > 0 ? Place::kUpper : Place::kLower;
  }
  for (int releases = 0, solves = 0; solves < kMaxFallbackSolves; ++solves) {
    ++result.free_set_solves;
    if (!factor_free_set(problem)) {
      result.status = QpStatus::kNotPositiveDefinite;
      x_ = feasible_;
      update_gradient(problem);
      return;
    }
    minimise_on_free_set(problem, Method::kCeres);
    if (!step_to_minimum(problem)) continue;
    const int released = variable_to_release(problem, releases++ >= kReleasesBeforeBland);
    if (released < 0) return;
    place_[released] = Place::kFree;
  }
  result.status = QpStatus::kIterationLimit;
  x_ = feasible_;
  update_gradient(problem);
}

/// Walks from feasible_ towards x_; true if it arrives, else the blocking variable has been put on its bound.
bool BoundedQp::step_to_minimum(const Problem& problem) noexcept {
  double step = 1;
  int blocking = -1;
  for (const int i : free_) {
    if (!(violation(problem, i) > 0)) continue;
    const double bound = x_[i] < 0 ? 0 : problem.upper[i];
    const double share = std::clamp((bound - feasible_[i]) / (x_[i] - feasible_[i]), 0.0, 1.0);
    if (blocking < 0 || share < step) {
      step = share;
      blocking = i;
    }
  }
  for (const int i : free_) {
    feasible_[i] = std::clamp(feasible_[i] + step * (x_[i] - feasible_[i]), 0.0, problem.upper[i]);
  }
  if (blocking < 0) return true;
  const bool at_upper = x_[blocking] > 0;
  place_[blocking] = at_upper ? Place::kUpper : Place::kLower;
  feasible_[blocking] = at_upper ? problem.upper[blocking] : 0;
  return false;
}

int BoundedQp::variable_to_release(const Problem& problem, bool least_index) const noexcept {
  int chosen = -1;
  double largest = 0;
  for (int i = 0; i < size_; ++i) {
    if (place_[i] == Place::kFree) continue;
    const double offence = violation(problem, i);
    if (!(offence > largest)) continue;
    chosen = i;
    if (least_index) break;
    largest = offence;
  }
  return chosen;
}

/// Free variables may lie outside by the tolerance; the caller is promised the bounds exactly.
void BoundedQp::move_inside_bounds(const Problem& problem) noexcept {
  bool moved = false;
  for (int i = 0; i < size_; ++i) {
    const double inside = std::clamp(x_[i], 0.0, problem.upper[i]);
    moved = moved || inside != x_[i];
    x_[i] = inside;
  }
  if (moved) update_gradient(problem);
}

double BoundedQp::kkt_residual(const Problem& problem) const noexcept {
  double worst = 0;
  for (int i = 0; i < size_; ++i) {
    const double projected = std::clamp(x_[i] - gradient_[i] / problem.h(i, i), 0.0, problem.upper[i]);
    worst = std::max(worst, std::abs(x_[i] - projected));
  }
  return worst;
}

void BoundedQp::inverse_diagonal(const Eigen::MatrixXd& h, Eigen::VectorXd& diagonal) noexcept {
  diagonal = h.diagonal().cwiseInverse();
  const std::span<double> variances = std::span(x_free_).first(free_.size());
  factor_holds_ = false;
  if (free_.empty() || !free_set_.factor(h, free_)) return;
  free_set_.inverse_diagonal(variances);
  for (std::size_t k = 0; k < free_.size(); ++k) diagonal[free_[k]] = variances[k];
}

}  // namespace risorius
