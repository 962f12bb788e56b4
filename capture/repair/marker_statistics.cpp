#include "capture/repair/marker_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {
namespace {

/// What a marker's residual is believed to be before it was seen, and how many samples that is worth.
constexpr double kPriorNoiseMm2 = 1.0;
constexpr double kNoisePriorSamples = 10;
/// The residual variance follows the model, so it forgets faster than the model itself.
constexpr double kNoiseMemorySamples = 50;
/// A leap of the tracker's clock must not make the model forget everything.
constexpr double kLongestFrameS = 1.0;

double require_positive(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return value;
  throw UserError(name, fmt::format("{} is not a positive number", value), "leave it out for the default");
}

}  // namespace

MarkerStatistics::MarkerStatistics(MarkerStatisticsOptions options) : options_(options) {
  require_positive("memory_s", options.memory_s);
  require_positive("noise_floor_mm", options.noise_floor_mm);
  require_positive("learn_rate_hz", options.learn_rate_hz);
  if (!(options.model_doubt >= 1 && std::isfinite(options.model_doubt))) {
    throw UserError("model_doubt", fmt::format("{} is not >= 1", options.model_doubt), "16 is the default");
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
  std::vector<Marker> mapped(old_index.size(), unseen_marker());
  for (std::size_t i = 0; i < old_index.size(); ++i) {
    if (old_index[i] >= 0) mapped[i] = markers_[static_cast<std::size_t>(old_index[i])];
  }
  markers_ = std::move(mapped);
  precision_valid_ = false;
}

void MarkerStatistics::reset() noexcept {
  std::fill(markers_.begin(), markers_.end(), unseen_marker());
  precision_.setIdentity();
  covariance_.setIdentity();
  latent_.setZero();
  precision_valid_ = false;
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
  condition_precision();
  Latent information = Latent::Zero();
  for (const Marker& marker : markers_) {
    if (!marker.visible) continue;
    information += marker.loading * ((marker.position_mm - marker.mean_mm) / marker.noise_mm2);
  }
  latent_.noalias() = covariance_ * information;
  for (Marker& marker : markers_) {
    if (!marker.visible) continue;
    const Eigen::Vector3d in_sample = marker.position_mm - marker.mean_mm - marker.loading.transpose() * latent_;
    marker.residual_mm.noalias() = marker.loo_gain * in_sample;
  }
}

void MarkerStatistics::add_to_precision(const Marker& marker, double sign) noexcept {
  precision_.noalias() += (sign / marker.noise_mm2) * marker.loading * marker.loading.transpose();
}

/// Adds and removes only the markers that came and went; starts afresh after each merge, so that rounding cannot pile
/// up.
void MarkerStatistics::condition_precision() noexcept {
  bool changed = !precision_valid_;
  if (!precision_valid_) {
    precision_.setIdentity();
    for (Marker& marker : markers_) {
      marker.conditioned = 0;
      marker.noise_mm2 = options_.model_doubt * marker.learnt_noise_mm2;
    }
  }
  for (Marker& marker : markers_) {
    if (marker.conditioned == marker.visible) continue;
    add_to_precision(marker, marker.visible ? 1.0 : -1.0);
    marker.conditioned = marker.visible;
    changed = true;
  }
  precision_valid_ = true;
  if (!changed) return;
  covariance_ = precision_.llt().solve(LatentSquare::Identity());
  for (Marker& marker : markers_) {
    const Loading carried = covariance_ * marker.loading;
    marker.spread_mm2.noalias() = marker.loading.transpose() * carried;
    if (marker.visible) {
      // residual_loo = (I - S / noise)^-1 residual, cov_loo = noise (I - S / noise)^-1, S = W_i cov(z) W_i^T
      marker.loo_gain = (Eigen::Matrix3d::Identity() - marker.spread_mm2 / marker.noise_mm2).inverse();
      marker.variance_mm2 = marker.noise_mm2 * marker.loo_gain.trace() / 3;
    } else {
      marker.loo_gain.setIdentity();
      marker.variance_mm2 = marker.noise_mm2 + marker.spread_mm2.trace() / 3;
    }
  }
}

Eigen::Vector3d MarkerStatistics::prediction_mm(std::size_t i) const noexcept {
  const Marker& marker = markers_[i];
  if (marker.visible) return marker.position_mm - marker.residual_mm;
  return marker.mean_mm + marker.loading.transpose() * latent_;
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
  block_s_ += std::min(since_learnt_s_, kLongestFrameS);
  since_learnt_s_ = 0;
  if (!informative()) return;
  const auto slot = static_cast<std::size_t>(block_size_);
  for (Marker& marker : markers_) {
    const Eigen::Vector3d explained = marker.loading.transpose() * latent_;
    marker.block_measured[slot] = marker.visible;
    marker.block_mm[slot] = explained;
    if (!marker.visible) continue;
    marker.block_mm[slot] = marker.position_mm - marker.mean_mm;
    const double squared = (marker.block_mm[slot] - explained).squaredNorm() + marker.spread_mm2.trace();
    const double rate = 1 / (kNoisePriorSamples + std::min(marker.samples, kNoiseMemorySamples));
    marker.learnt_noise_mm2 = std::max(marker.learnt_noise_mm2 + rate * (squared / 3 - marker.learnt_noise_mm2),
                                       options_.noise_floor_mm * options_.noise_floor_mm);
    if (marker.samples == 0) marker.samples = 1;
  }
  if (++block_size_ == kBlock) merge_block();
}

/// Centres the marker's block on its own mean, moves the marker's mean, and keeps the shift for the merge.
void MarkerStatistics::centre_block(Marker& marker) noexcept {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  double measured = 0;
  for (std::size_t k = 0; k < kBlock; ++k) {
    if (!marker.block_measured[k]) continue;
    shift += marker.block_mm[k];
    measured += 1;
  }
  marker.shift_mm.setZero();
  if (measured == 0) return;
  shift /= measured;
  for (std::size_t k = 0; k < kBlock; ++k) {
    if (marker.block_measured[k]) marker.block_mm[k] -= shift;
  }
  const double before = marker.samples;
  marker.samples = before + measured;
  marker.mean_mm += measured / marker.samples * shift;
  marker.shift_mm = std::sqrt(before * measured / marker.samples) * shift;
}

/// The marker's three rows of D = [ W sqrt(window) | block - block mean | weighted shift of the mean ], transposed.
Eigen::Matrix<double, MarkerStatistics::kMerged, 3> MarkerStatistics::merged_rows(const Marker& marker) const noexcept {
  Eigen::Matrix<double, kMerged, 3> rows;
  rows.topRows<kRank>() = std::sqrt(window_) * marker.loading;
  for (int k = 0; k < kBlock; ++k) {
    rows.row(kRank + k) = marker.block_mm[static_cast<std::size_t>(k)].transpose();
  }
  rows.row(kMerged - 1) = marker.shift_mm.transpose();
  return rows;
}

/// With D = U S V^T the new W is U S = D V, leading columns, over the square root of the window.
void MarkerStatistics::merge_block() noexcept {
  const double keep = std::exp(-block_s_ / options_.memory_s);
  window_ *= keep;
  using Square = Eigen::Matrix<double, kMerged, kMerged>;
  Square gram = Square::Zero();
  for (Marker& marker : markers_) {
    marker.samples *= keep;
    centre_block(marker);
    const auto rows = merged_rows(marker);
    gram.noalias() += rows * rows.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Square> eigen(gram);
  const Eigen::Matrix<double, kMerged, kRank> leading = eigen.eigenvectors().rightCols<kRank>();
  const double scale = 1 / std::sqrt(window_ + kBlock);
  for (Marker& marker : markers_) marker.loading = scale * leading.transpose() * merged_rows(marker);

  // The directions have turned; the latent state turns with them: W_new z_new = W_old z_old.
  const Latent turned = leading.topRows<kRank>().transpose() * latent_;
  if (window_ > 0) latent_ = turned / (scale * std::sqrt(window_));
  window_ += kBlock;
  block_size_ = 0;
  block_s_ = 0;
  precision_valid_ = false;
}

}  // namespace risorius
