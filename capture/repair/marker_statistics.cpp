#include "capture/repair/marker_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <ranges>

#include "capture/errors.h"
#include "capture/repair/online_model.h"

namespace risorius {
namespace {

/// What a marker's residual is believed to be before it was seen, and how many samples that is worth.
constexpr double kPriorNoiseMm2 = 1.0;
constexpr double kNoisePriorSamples = 10;
/// The residual variance follows the model, so it forgets faster than the model itself.
constexpr double kNoiseMemorySamples = 50;
/// One marker's coming or going costs a fifth of conditioning afresh.
constexpr int kMostChangesAtOnce = 4;
constexpr int kChangesInARow = 64;

}  // namespace

MarkerStatistics::MarkerStatistics(MarkerStatisticsOptions options) : options_(options) {
  require_positive("memory_s", options.memory_s);
  require_positive("noise_floor_mm", options.noise_floor_mm);
  require_positive("learn_rate_hz", options.learn_rate_hz);
  if (!(options.model_doubt >= 1 && std::isfinite(options.model_doubt))) {
    throw UserError("model_doubt", fmt::format("{} is not >= 1", options.model_doubt), "4 is the default");
  }
  reset();
}

MarkerStatistics::Marker MarkerStatistics::unseen_marker() noexcept {
  Marker marker;
  marker.learnt_noise_mm2 = kPriorNoiseMm2;
  marker.noise_mm2 = kPriorNoiseMm2;
  marker.block_mm.fill(Eigen::Vector3d::Zero());
  return marker;
}

void MarkerStatistics::remap(const std::vector<int>& old_index) {
  // A source that starts again has the same markers: then nothing is allocated.
  if (std::ranges::equal(old_index, std::views::iota(0, static_cast<int>(markers_.size())))) {
    merged_mm_.setZero();
    changes_until_afresh_ = 0;
    return;
  }
  std::vector<Marker> mapped(old_index.size(), unseen_marker());
  Loadings loadings = Loadings::Zero(kRank, static_cast<Eigen::Index>(3 * old_index.size()));
  for (std::size_t i = 0; i < old_index.size(); ++i) {
    if (old_index[i] < 0) continue;
    const auto old = static_cast<std::size_t>(old_index[i]);
    mapped[i] = markers_[old];
    loadings.middleCols<3>(static_cast<Eigen::Index>(3 * i)) = loading(old);
  }
  markers_ = std::move(mapped);
  loadings_mm_ = std::move(loadings);
  merged_mm_.setZero(kMerged, loadings_mm_.cols());
  changes_until_afresh_ = 0;
}

void MarkerStatistics::reset() noexcept {
  std::fill(markers_.begin(), markers_.end(), unseen_marker());
  loadings_mm_.setZero();
  covariance_.setIdentity();
  latent_.setZero();
  changes_until_afresh_ = 0;
  block_size_ = 0;
  block_s_ = since_learnt_s_ = window_ = 0;
}

void MarkerStatistics::observe(const std::vector<Eigen::Vector3d>& position_head_mm,
                               const std::vector<std::uint8_t>& visible) noexcept {
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    markers_[i].visible = visible[i];
    if (!visible[i]) continue;
    markers_[i].position_mm = position_head_mm[i];
    if (!seen(i)) markers_[i].mean_mm = position_head_mm[i];
  }
  update();
}

void MarkerStatistics::update() noexcept {
  condition();
  Latent information = Latent::Zero();
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const Marker& marker = markers_[i];
    if (!marker.visible) continue;
    const Eigen::Vector3d scaled = (marker.position_mm - marker.mean_mm) / marker.noise_mm2;
    information += loading(i).lazyProduct(scaled);
  }
  latent_ = covariance_.lazyProduct(information);
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    if (!marker.visible) continue;
    const Eigen::Vector3d in_sample = marker.position_mm - marker.mean_mm - explained_mm(i);
    marker.residual_mm.noalias() = marker.loo_gain * in_sample;
  }
}

/// Markers that came or went are worked in one by one. After each merge, after many changes at once and after many in
/// a row all is made anew, so that rounding cannot pile up.
void MarkerStatistics::condition() noexcept {
  int changed = 0;
  for (const Marker& marker : markers_) changed += marker.conditioned != marker.visible;
  if (changes_until_afresh_ == 0 || changed > std::min(kMostChangesAtOnce, changes_until_afresh_)) {
    condition_afresh();
    return;
  }
  if (changed == 0) return;
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (markers_[i].conditioned != markers_[i].visible) condition_on_change(i);
  }
  for (Marker& marker : markers_) derive_gain(marker);
}

/// All markers are believed alike: the still ones have the least noise of their own, and given their due they would
/// insist that an expression which they do not show is none.
void MarkerStatistics::renew_noise() noexcept {
  double sum = 0, known = 0;
  for (const Marker& marker : markers_) {
    if (marker.samples > 0) sum += marker.learnt_noise_mm2, known += 1;
  }
  const double noise = options_.model_doubt * (known > 0 ? sum / known : kPriorNoiseMm2);
  for (Marker& marker : markers_) marker.noise_mm2 = noise;
}

void MarkerStatistics::condition_afresh() noexcept {
  if (changes_until_afresh_ == 0) renew_noise();
  LatentSquare precision = LatentSquare::Identity();
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    marker.conditioned = marker.visible;
    if (!marker.visible) continue;
    const Eigen::Matrix<double, kRank, 3> scaled = loading(i) / marker.noise_mm2;
    precision += scaled.lazyProduct(loading(i).transpose());
  }
  LatentSquare whitener = LatentSquare::Identity();
  precision.llt().matrixL().solveInPlace(whitener);
  covariance_ = whitener.transpose().lazyProduct(whitener);
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const Eigen::Matrix<double, kRank, 3> whitened = whitener.lazyProduct(loading(i));
    markers_[i].spread_mm2 = whitened.transpose().lazyProduct(whitened);
    derive_gain(markers_[i]);
  }
  changes_until_afresh_ = kChangesInARow;
}

/// Woodbury: with U = cov(z) W_i^T, cov(z) changes by -U (noise I + S_i)^-1 U^T where marker i comes, and by
/// +U (noise I - S_i)^-1 U^T where it goes.
void MarkerStatistics::condition_on_change(std::size_t i) noexcept {
  Marker& changed = markers_[i];
  const double sign = changed.visible ? 1.0 : -1.0;
  const Eigen::Matrix<double, kRank, 3> u = covariance_.lazyProduct(loading(i));
  const Eigen::Matrix3d inner =
      sign * (changed.noise_mm2 * Eigen::Matrix3d::Identity() + sign * changed.spread_mm2).inverse();
  for (std::size_t j = 0; j < markers_.size(); ++j) {
    const Eigen::Matrix3d reach = loading(j).transpose().lazyProduct(u);
    const Eigen::Matrix3d weighed = reach.lazyProduct(inner);
    markers_[j].spread_mm2 -= weighed.lazyProduct(reach.transpose());
  }
  const Eigen::Matrix<double, kRank, 3> weighed = u.lazyProduct(inner);
  covariance_ -= weighed.lazyProduct(u.transpose());
  changed.conditioned = changed.visible;
  --changes_until_afresh_;
}

/// residual_loo = (I - S / noise)^-1 residual, cov_loo = noise (I - S / noise)^-1, S = W_i cov(z) W_i^T
void MarkerStatistics::derive_gain(Marker& marker) const noexcept {
  if (marker.visible) {
    marker.loo_gain = (Eigen::Matrix3d::Identity() - marker.spread_mm2 / marker.noise_mm2).inverse();
    marker.variance_mm2 = marker.noise_mm2 * marker.loo_gain.trace() / 3;
  } else {
    marker.loo_gain.setIdentity();
    marker.variance_mm2 = marker.noise_mm2 + marker.spread_mm2.trace() / 3;
  }
}

Eigen::Vector3d MarkerStatistics::prediction_mm(std::size_t i) const noexcept {
  const Marker& marker = markers_[i];
  if (marker.visible) return marker.position_mm - marker.residual_mm;
  return marker.mean_mm + explained_mm(i);
}

/// A frame in which most markers are hidden would mostly teach what was predicted.
bool MarkerStatistics::informative() const noexcept {
  std::size_t known = 0, measured = 0;
  for (const Marker& marker : markers_) {
    measured += marker.visible;
    known += marker.visible || marker.samples > 0;
  }
  return measured >= 3 && 2 * measured >= known;
}

void MarkerStatistics::learn(double step_s) noexcept {
  since_learnt_s_ += step_s;
  if (since_learnt_s_ * options_.learn_rate_hz < 0.999) return;
  block_s_ += std::min(since_learnt_s_, kLongestForgottenS);
  since_learnt_s_ = 0;
  if (!informative()) return;
  const auto slot = static_cast<std::size_t>(block_size_);
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    Marker& marker = markers_[i];
    const Eigen::Vector3d explained = explained_mm(i);
    marker.block_mm[slot] = explained;
    if (!marker.visible) continue;
    marker.block_mm[slot] = marker.position_mm - marker.mean_mm;
    const double squared = (marker.block_mm[slot] - explained).squaredNorm() + marker.spread_mm2.trace();
    const double rate = 1 / (kNoisePriorSamples + std::min(marker.samples, kNoiseMemorySamples));
    marker.learnt_noise_mm2 = std::max(marker.learnt_noise_mm2 + rate * (squared / 3 - marker.learnt_noise_mm2),
                                       options_.noise_floor_mm * options_.noise_floor_mm);
    if (marker.samples == 0) marker.samples = 1;
  }
  if (++block_size_ < kBlock) return;
  merge_block();
  condition();  // now, not when the next frame waits
}

/// Centres the marker's block on its own mean, moves the marker's mean, and keeps the shift for the merge. Where the
/// marker was hidden the block holds what the others say of it, and that counts like a sample: a block that left it out
/// would teach that this marker stays while the others move.
void MarkerStatistics::centre_block(Marker& marker) noexcept {
  marker.shift_mm.setZero();
  if (marker.samples == 0) return;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& deviation : marker.block_mm) shift += deviation / kBlock;
  for (Eigen::Vector3d& deviation : marker.block_mm) deviation -= shift;
  const double before = marker.samples;
  marker.samples = before + kBlock;
  marker.mean_mm += kBlock / marker.samples * shift;
  marker.shift_mm = std::sqrt(before * kBlock / marker.samples) * shift;
}

/// D^T = [ W sqrt(window) | block - block mean | weighted shift of the mean ]^T, three columns per marker.
void MarkerStatistics::gather_merged() noexcept {
  merged_mm_.topRows<kRank>() = std::sqrt(window_) * loadings_mm_;
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(3 * i);
    for (int k = 0; k < kBlock; ++k) {
      merged_mm_.block<1, 3>(kRank + k, column) = markers_[i].block_mm[static_cast<std::size_t>(k)].transpose();
    }
    merged_mm_.block<1, 3>(kMerged - 1, column) = markers_[i].shift_mm.transpose();
  }
}

/// With D = U S V^T the new W is U S = D V, leading columns, over the square root of the window.
void MarkerStatistics::merge_block() noexcept {
  const double keep = std::exp(-block_s_ / options_.memory_s);
  window_ *= keep;
  for (Marker& marker : markers_) {
    marker.samples *= keep;
    centre_block(marker);
  }
  gather_merged();
  using Square = Eigen::Matrix<double, kMerged, kMerged>;
  Square gram;
  gram.noalias() = merged_mm_ * merged_mm_.transpose();
  const Eigen::SelfAdjointEigenSolver<Square> eigen(gram);
  const Eigen::Matrix<double, kMerged, kRank> leading = eigen.eigenvectors().rightCols<kRank>();
  const double scale = 1 / std::sqrt(window_ + kBlock);
  loadings_mm_.noalias() = (scale * leading).transpose() * merged_mm_;

  // The directions have turned; the latent state turns with them: W_new z_new = W_old z_old.
  const Latent turned = leading.topRows<kRank>().transpose() * latent_;
  if (window_ > 0) latent_ = turned / (scale * std::sqrt(window_));
  window_ += kBlock;
  block_size_ = 0;
  block_s_ = 0;
  changes_until_afresh_ = 0;
}

}  // namespace risorius
