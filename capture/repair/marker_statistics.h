// How markers of a face move together: an online low-rank model of the 3M coordinates in the head frame,
//   y = mean + W z + e,   z ~ N(0, I),   e ~ N(0, noise I),
// and what the visible markers say about any marker that is hidden, with the variance of that statement.
//
// W is kept as the scaled principal directions of a window that forgets exponentially; blocks of frames are merged by
// an incremental SVD with mean update (Ross et al. 2008, "Incremental learning for robust visual tracking", sec. 2).
// Conditioning is Gaussian, in the r-dimensional latent space (an r x r solve).
// Memory is bounded and allocated in remap(); nothing is learnt from markers that are not measured and trusted.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace risorius {

/// Why model_doubt? The directions are estimates themselves, and a new expression lies outside of them: believed at
/// face value, weak directions explode. Measured on a real take (eyebrows) while it is being learnt: 1 and 16 are
/// worse.
struct MarkerStatisticsOptions {
  double memory_s = 60;          ///< time constant of forgetting, > 0
  double noise_floor_mm = 0.05;  ///< no marker is believed to be measured better than this (per axis), > 0
  double model_doubt = 4;  ///< conditioning believes in this many times the learnt noise (the mean over markers), >= 1
  double learn_rate_hz = 60;  ///< at most so many frames a second are learnt from, > 0
};

class MarkerStatistics {
 public:
  static constexpr int kRank = 16;
  static constexpr int kBlock = 16;  ///< frames that are merged at a time

  /// Throws UserError for an option out of its range.
  explicit MarkerStatistics(MarkerStatisticsOptions options = {});

  /// Allocates. Marker i takes over what was known of old_index[i]; -1 is a marker never seen.
  void remap(const std::vector<int>& old_index);
  void reset() noexcept;

  /// Conditions the model on the markers that are visible (1); positions are in the head frame.
  void observe(const std::vector<Eigen::Vector3d>& position_head_mm, const std::vector<std::uint8_t>& visible) noexcept;
  /// Takes marker i out of (back into) the visible ones of the frame last observed; then call update().
  void hide(std::size_t i) noexcept { markers_[i].visible = 0; }
  void unhide(std::size_t i) noexcept { markers_[i].visible = 1; }
  void update() noexcept;
  /// Learns from the frame last observed.
  void learn(double step_s) noexcept;

  std::size_t count() const noexcept { return markers_.size(); }
  bool seen(std::size_t i) const noexcept { return markers_[i].samples > 0; }
  bool visible(std::size_t i) const noexcept { return markers_[i].visible != 0; }
  /// Where the *other* visible markers say that marker i is. A marker never seen has no prediction (zero).
  Eigen::Vector3d prediction_mm(std::size_t i) const noexcept;
  /// Measured position less prediction_mm(i). Visible markers only.
  const Eigen::Vector3d& residual_mm(std::size_t i) const noexcept { return markers_[i].residual_mm; }
  /// The model's own variance of that prediction, per axis.
  double variance_mm2(std::size_t i) const noexcept { return markers_[i].variance_mm2; }
  const Eigen::Vector3d& mean_mm(std::size_t i) const noexcept { return markers_[i].mean_mm; }

 private:
  using Latent = Eigen::Matrix<double, kRank, 1>;
  using LatentSquare = Eigen::Matrix<double, kRank, kRank>;
  static constexpr int kMerged = kRank + kBlock + 1;
  using Loadings = Eigen::Matrix<double, kRank, Eigen::Dynamic>;

  struct Marker {
    Eigen::Matrix3d loo_gain = Eigen::Matrix3d::Identity();  ///< from in-sample to leave-one-out residual
    Eigen::Matrix3d spread_mm2 = Eigen::Matrix3d::Zero();    ///< W_i cov(z) W_i^T
    Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d residual_mm = Eigen::Vector3d::Zero();
    double variance_mm2 = 0;
    double noise_mm2 = 0;  ///< as the conditioning uses it; renewed with the model
    double learnt_noise_mm2 = 0;
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();  ///< of the mean by the block at hand, weighted
    double samples = 0;                                  ///< forgotten exponentially
    std::uint8_t visible = 0;
    std::uint8_t conditioned = 0;                  ///< was visible to covariance_
    std::array<Eigen::Vector3d, kBlock> block_mm;  ///< deviations from the mean, waiting to be merged
  };

  static Marker unseen_marker() noexcept;
  auto loading(std::size_t i) const noexcept { return loadings_mm_.middleCols<3>(static_cast<Eigen::Index>(3 * i)); }
  Eigen::Vector3d explained_mm(std::size_t i) const noexcept { return loading(i).transpose().lazyProduct(latent_); }
  void condition() noexcept;
  void condition_afresh() noexcept;
  void renew_noise() noexcept;
  void condition_on_change(std::size_t i) noexcept;
  void derive_gain(Marker& marker) const noexcept;
  bool informative() const noexcept;
  void merge_block() noexcept;
  static void centre_block(Marker& marker) noexcept;
  void gather_merged() noexcept;

  MarkerStatisticsOptions options_;
  std::vector<Marker> markers_;
  Loadings loadings_mm_;                                      ///< W^T: three columns per marker
  Eigen::Matrix<double, kMerged, Eigen::Dynamic> merged_mm_;  ///< of merge_block(): three columns per marker
  LatentSquare covariance_;                                   ///< of z, given the visible markers
  Latent latent_ = Latent::Zero();
  int changes_until_afresh_ = 0;  ///< 0: covariance_ must be made anew
  int block_size_ = 0;
  double block_s_ = 0;
  double since_learnt_s_ = 0;
  double window_ = 0;  ///< frames behind W, forgotten exponentially
};

}  // namespace risorius
