#include "capture/repair/marker_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <ranges>

#include "capture/repair/cholesky.h"
#include "capture/repair/online_model.h"
#include "capture/repair/symmetric_update.h"

namespace risorius {
namespace {

/// Forgetting would leave nothing in directions that never move. One coordinate in so many frames gets its ridge back.
constexpr int kRidgeEveryFrames = 4;
/// With more coordinates hidden, the leave-one-out predictions take what is filled for seen: their only use is to say
/// what a residual is worth, and exact ones would cost as much as everything else together.
constexpr std::size_t kMostHiddenExactly = 24;

}  // namespace

MarkerCovariance::MarkerCovariance(MarkerCovarianceOptions options) : options_(options) {
  require_positive("memory_s", options.memory_s);
  require_positive("rest_s", options.rest_s);
  require_positive("reach_mm", options.reach_mm);
  require_positive("alike_mm", options.alike_mm);
  require_positive("alone_mm", options.alone_mm);
  require_positive("prior_samples", options.prior_samples);
  require_positive("mode_strength", options.mode_strength);
  require_positive("unknown_share", options.unknown_share);
}

void MarkerCovariance::remap(const std::vector<int>& old_index) {
  // A source that starts again has the same markers: then nothing is allocated.
  if (std::ranges::equal(old_index, std::views::iota(0, static_cast<int>(markers_.size())))) return;
  const std::size_t count = old_index.size();
  const auto size = static_cast<Eigen::Index>(3 * count);
  precision_ = precision_of_kept(old_index);
  std::vector<Marker> mapped(count);
  Eigen::VectorXd deviation = Eigen::VectorXd::Zero(size);
  for (std::size_t i = 0; i < count; ++i) {
    if (old_index[i] < 0) continue;
    const auto old = static_cast<std::size_t>(old_index[i]);
    mapped[i] = markers_[old];
    deviation.segment<3>(at(i)) = deviation_mm_.segment<3>(at(old));
  }
  markers_ = std::move(mapped);
  deviation_mm_ = std::move(deviation);
  sum_mm_ = Eigen::VectorXd::Zero(size);
  direction_ = pull_ = sum_pull_ = Eigen::VectorXd::Zero(size);
  is_prepared_ = false;
  reach_ = Eigen::MatrixXd::Zero(size, 3);
  factor_.assign(9 * count * count, 0);
  hidden_.clear();
  hidden_.reserve(count);
  summed_ = 0;
  next_ridge_ = 0;
  modes_.forget();
  must_condition_ = true;
}

/// A without the rows and columns of the markers that go has P_kk - P_kg P_gg^-1 P_gk for its inverse; a newcomer's
/// rows of A hold nothing but the ridge. So neither A itself is needed nor an inverse of its size.
Eigen::MatrixXd MarkerCovariance::precision_of_kept(const std::vector<int>& old_index) const {
  std::vector<Eigen::Index> place, kept, gone;  // new and old coordinates of what stays, old ones of what goes
  std::vector<bool> stays(markers_.size(), false);
  for (std::size_t i = 0; i < old_index.size(); ++i) {
    if (old_index[i] < 0) continue;
    stays[static_cast<std::size_t>(old_index[i])] = true;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      place.push_back(at(i) + axis);
      kept.push_back(3 * old_index[i] + axis);
    }
  }
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    for (Eigen::Index axis = 0; axis < 3 && !stays[i]; ++axis) gone.push_back(at(i) + axis);
  }
  Eigen::MatrixXd known = precision_(kept, kept);
  if (!gone.empty() && !kept.empty()) {
    const Eigen::LLT<Eigen::MatrixXd> factor(precision_(gone, gone));
    const Eigen::MatrixXd reach = factor.matrixL().solve(Eigen::MatrixXd(precision_(gone, kept)));
    known.selfadjointView<Eigen::Lower>().rankUpdate(reach.transpose(), -1);
    known.triangularView<Eigen::StrictlyUpper>() = known.transpose();
  }
  const auto size = static_cast<Eigen::Index>(3 * old_index.size());
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(size, size);
  precision.diagonal().setConstant(1 / ridge());
  precision(place, place) = known;
  return precision;
}

void MarkerCovariance::reset() noexcept {
  std::fill(markers_.begin(), markers_.end(), Marker{});
  deviation_mm_.setZero();
  sum_mm_.setZero();
  precision_.setZero();
  precision_.diagonal().setConstant(1 / ridge());
  frames_ = forgotten_ = 0;
  since_ridge_ = 0;
  summed_ = 0;
  next_ridge_ = 0;
  hidden_.clear();
  has_shifted_ = is_prepared_ = false;
  modes_.reset();
  must_condition_ = true;
}

/// Of a coordinate, where no neighbour is known: n0 (1 + 1) mm^2 by default.
double MarkerCovariance::ridge() const noexcept {
  return options_.prior_samples * (options_.alike_mm * options_.alike_mm + options_.alone_mm * options_.alone_mm);
}

void MarkerCovariance::observe(const std::vector<Eigen::Vector3d>& position_head_mm,
                               const std::vector<std::uint8_t>& visible) noexcept {
  is_prepared_ = false;
  bool has_newcomers = false;
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    marker.visible = visible[i] != 0;
    if (!marker.visible || marker.seen) continue;
    has_newcomers = marker.seen = true;
    marker.rest_mm = position_head_mm[i];
  }
  if (has_newcomers) believe_newcomers();
  has_shifted_ = conditions_changed();
  if (has_shifted_) {
    note_predictions();
    condition();
    complete();
    note_shifts();
  }
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    marker.whole = marker.visible && (marker.whole || summed_ == 0);
    if (marker.visible) deviation_mm_.segment<3>(at(i)) = position_head_mm[i] - marker.rest_mm;
  }
  complete();
  sum_mm_ += deviation_mm_;
  ++summed_;
}

bool MarkerCovariance::conditions_changed() const noexcept {
  if (must_condition_) return true;
  return std::ranges::any_of(markers_, [](const Marker& m) { return m.seen && m.conditioned != m.visible; });
}

/// Of the frame before, under what was conditioned on so far; kept in shift_mm until note_shifts().
void MarkerCovariance::note_predictions() noexcept {
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const bool wanted = markers_[i].seen && !markers_[i].visible;
    markers_[i].shift_mm = wanted ? deviation_predicted(i) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
}

void MarkerCovariance::note_shifts() noexcept {
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (markers_[i].seen && !markers_[i].visible) markers_[i].shift_mm -= deviation_predicted(i);
  }
}

Eigen::Vector3d MarkerCovariance::deviation_predicted(std::size_t i) noexcept {
  const Eigen::Vector3d deviation = deviation_mm_.segment<3>(at(i));
  return markers_[i].conditioned ? Eigen::Vector3d(deviation - residual_of(i, deviation_mm_)) : deviation;
}

Eigen::Vector3d MarkerCovariance::prediction_mm(std::size_t i) noexcept {
  return markers_[i].rest_mm + deviation_predicted(i);
}

/// With P_i the rows of marker i, residual = (P_ii given the hidden ones)^-1 P_i d.
Eigen::Vector3d MarkerCovariance::residual_of(std::size_t i, const Eigen::VectorXd& deviation_mm) noexcept {
  condition_visible(i);
  const auto rows = precision_of(i);
  const Eigen::Vector3d pull(rows.col(0).dot(deviation_mm), rows.col(1).dot(deviation_mm),
                             rows.col(2).dot(deviation_mm));
  return markers_[i].leave_one_out_mm2 * pull;
}

void MarkerCovariance::prepare_to_learn() noexcept {
  multiply_symmetric(precision_, deviation_mm_, pull_);
  if (summed_ > 1) multiply_symmetric(precision_, sum_mm_, sum_pull_);
  is_prepared_ = true;
}

Eigen::Vector3d MarkerCovariance::mean_residual_mm(std::size_t i) noexcept {
  const bool of_mean = summed_ > 1 && markers_[i].whole;
  const int frames = of_mean ? summed_ : 1;
  if (!is_prepared_) return residual_of(i, of_mean ? sum_mm_ : deviation_mm_) / frames;
  condition_visible(i);
  return markers_[i].leave_one_out_mm2 * (of_mean ? sum_pull_ : pull_).segment<3>(at(i)) / frames;
}

void MarkerCovariance::condition() noexcept {
  hidden_.clear();
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    marker.conditioned = marker.visible;
    marker.is_left_out = false;
    if (marker.seen && !marker.visible) hidden_.push_back(i);
  }
  const auto size = static_cast<Eigen::Index>(3 * hidden_.size());
  Eigen::Map<Eigen::MatrixXd> factor(factor_.data(), size, size);
  for (std::size_t c = 0; c < hidden_.size(); ++c) {
    for (std::size_t r = c; r < hidden_.size(); ++r) {
      factor.block<3, 3>(at(r), at(c)) = precision_.block<3, 3>(at(hidden_[r]), at(hidden_[c]));
    }
  }
  factorize_lower(factor);
  for (std::size_t k = 0; k < hidden_.size(); ++k) condition_hidden(k);
  must_condition_ = false;
}

/// P_ii - P_ih P_hh^-1 P_hi is the precision of marker i given the other visible ones. Only when somebody asks: for
/// most markers that is once per learnt frame, and not whenever another comes or goes.
void MarkerCovariance::condition_visible(std::size_t i) noexcept {
  Marker& marker = markers_[i];
  if (!marker.conditioned || marker.is_left_out) return;
  marker.is_left_out = true;
  Eigen::Matrix3d own = precision_.block<3, 3>(at(i), at(i));
  if (hidden_.size() <= kMostHiddenExactly && !hidden_.empty()) {
    const auto size = static_cast<Eigen::Index>(3 * hidden_.size());
    auto whitened = reach_.topRows(size);
    for (std::size_t k = 0; k < hidden_.size(); ++k) {
      whitened.middleRows<3>(at(k)) = precision_.block<3, 3>(at(hidden_[k]), at(i));
    }
    solve_lower(Eigen::Map<const Eigen::MatrixXd>(factor_.data(), size, size), whitened);
    own -= whitened.transpose().lazyProduct(whitened);
  }
  marker.leave_one_out_mm2 = own.inverse();
  marker.variance_mm2 = marker.leave_one_out_mm2.trace() / 3 / (frames_ + options_.prior_samples);
}

void MarkerCovariance::condition_hidden(std::size_t k) noexcept {
  const auto size = static_cast<Eigen::Index>(3 * hidden_.size());
  auto whitened = reach_.topRows(size);
  whitened.setZero();
  whitened.middleRows<3>(at(k)).setIdentity();
  solve_lower(Eigen::Map<const Eigen::MatrixXd>(factor_.data(), size, size), whitened);
  markers_[hidden_[k]].variance_mm2 = whitened.squaredNorm() / 3 / (frames_ + options_.prior_samples);
}

/// Hidden markers get the deviation that the visible ones leave to be expected.
void MarkerCovariance::complete() noexcept {
  if (hidden_.empty()) return;
  for (const std::size_t i : hidden_) deviation_mm_.segment<3>(at(i)).setZero();
  const auto size = static_cast<Eigen::Index>(3 * hidden_.size());
  auto pull = reach_.col(0).head(size);
  for (std::size_t k = 0; k < hidden_.size(); ++k) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      pull[at(k) + axis] = -precision_.col(at(hidden_[k]) + axis).dot(deviation_mm_);
    }
  }
  const Eigen::Map<const Eigen::MatrixXd> factor(factor_.data(), size, size);
  solve_lower(factor, pull);
  solve_lower_transposed(factor, pull);
  for (std::size_t k = 0; k < hidden_.size(); ++k) deviation_mm_.segment<3>(at(hidden_[k])) = pull.segment<3>(at(k));
}

/// A frame in which most markers are hidden would mostly teach what was predicted.
bool MarkerCovariance::is_informative() const noexcept {
  const auto measured = std::ranges::count_if(markers_, &Marker::visible);
  return measured >= 3 && 2 * measured >= std::ranges::count_if(markers_, &Marker::seen);
}

void MarkerCovariance::learn(double step_s) noexcept {
  const double believed_s = std::min(step_s, kLongestForgottenS);
  sum_mm_.setZero();
  summed_ = 0;
  if (is_informative()) {
    const double keep = std::exp(-believed_s / options_.memory_s);
    frames_ = keep * frames_ + 1;
    add_square(keep);
    renew_ridge(1 - keep);
  }
  const double follow = 1 - std::exp(-believed_s / options_.rest_s);
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (markers_[i].seen) markers_[i].rest_mm += follow * deviation_mm_.segment<3>(at(i));
  }
  deviation_mm_ *= 1 - follow;
  is_prepared_ = false;
  condition();
}

/// A becomes keep A + d d^T, with d in deviation_mm_. P stays symmetric to the bit: so its errors cannot grow.
void MarkerCovariance::add_square(double keep) noexcept {
  if (!is_prepared_) multiply_symmetric(precision_, deviation_mm_, pull_);
  direction_ = pull_ / std::sqrt(keep * (keep + pull_.dot(deviation_mm_)));
  scale_less_square(precision_, 1 / keep, direction_);
}

/// A gets back at one coordinate, for all of them, what was forgotten of the ridge.
void MarkerCovariance::renew_ridge(double share) noexcept {
  const Eigen::Index size = deviation_mm_.size();
  forgotten_ += share;
  if (++since_ridge_ < kRidgeEveryFrames) return;
  const double weight = forgotten_ * static_cast<double>(size) * ridge();
  since_ridge_ = 0;
  forgotten_ = 0;
  direction_ = precision_.col(next_ridge_) * std::sqrt(weight / (1 + weight * precision_(next_ridge_, next_ridge_)));
  scale_less_square(precision_, 1, direction_);
  next_ridge_ = (next_ridge_ + 1) % size;
}

}  // namespace risorius
