// How the markers of a face move together: an online covariance of all 3M coordinates in the head's frame, of their
// deviations from a rest that follows slowly (so that it holds how markers *move*, not where they happen to stay), and
// what the visible markers say about any marker that is hidden, with the variance of that statement.
//   A = sum of d d^T over the n frames learnt from, forgotten exponentially + n0 (K + ridge I)
// K: what is believed of a marker when it is seen first: that neighbours move alike, exp(-distance^2 / (2 reach^2)),
// and, where it is known how this face moves (KnownMotion: a rig), as it is known.
// Conditioning is Gaussian, through P = A^-1: with v visible and h hidden, d_h = -P_hh^-1 P_hv d_v with covariance
// P_hh^-1 / (n + n0), a solve of the size of what is hidden. P follows every learnt frame by a rank-1 update: what
// moved just now says most of what will move. Memory is bounded and allocated in remap(); nothing is learnt from
// markers that are not measured and trusted, but for a hidden marker's prediction, which counts like a sample.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "capture/repair/known_motion.h"

namespace risorius {

/// Why rest_s? In deviations from the mean of the whole take, slow drifts outweigh what a gap is about: measured on
/// nine takes, 0.25 to 0.5 s are best and the mean over all is worst. Why prior_samples? Samples in a row repeat each
/// other, and a new expression lies outside of all of them.
struct MarkerCovarianceOptions {
  double memory_s = 60;         ///< time constant of forgetting, > 0
  double rest_s = 0.4;          ///< time constant of the rest, > 0
  double reach_mm = 40;         ///< markers this near are believed to move alike, > 0
  double alike_mm = 1;          ///< standard deviation of what they do alike, per axis, at first, > 0
  double alone_mm = 1;          ///< and of what each does alone, > 0
  double prior_samples = 40;    ///< n0: frames that this belief is worth, > 0
  double mode_strength = 0.15;  ///< standard deviation of a known mode, in full strengths, > 0
  double unknown_share = 0.4;   ///< of alike_mm^2 and alone_mm^2, for markers whose motion is known, > 0
};

class MarkerCovariance {
 public:
  /// Throws UserError for an option out of its range.
  explicit MarkerCovariance(MarkerCovarianceOptions options = {});

  /// Allocates. Marker i takes over what was known of old_index[i]; -1 is a marker never seen.
  void remap(const std::vector<int>& old_index);
  /// After a remap() to other markers, with the names of the set: what is known of this face, or null. Markers that
  /// were seen before keep what was believed then. Allocates.
  void know(std::shared_ptr<const KnownMotion> motion, const std::vector<std::string>& names) {
    modes_.use(std::move(motion), names);
  }
  void reset() noexcept;

  /// Conditions on the markers that are visible (1); positions are in the head frame.
  void observe(const std::vector<Eigen::Vector3d>& position_head_mm, const std::vector<std::uint8_t>& visible) noexcept;
  /// Learns from the frame last observed, step_s after the one last learnt from. 60 frames a second suffice.
  void learn(double step_s) noexcept;

  std::size_t count() const noexcept { return markers_.size(); }
  bool seen(std::size_t i) const noexcept { return markers_[i].seen; }
  bool visible(std::size_t i) const noexcept { return markers_[i].visible; }
  /// Where the *other* visible markers say that marker i is. A marker never seen has no prediction (zero).
  Eigen::Vector3d prediction_mm(std::size_t i) noexcept;
  /// Measured position less prediction_mm(i), of a marker that is visible.
  Eigen::Vector3d residual_mm(std::size_t i) noexcept { return residual_of(i, deviation_mm_); }
  /// Ahead of learn(), if mean_residual_mm is asked of most markers: one product that learn() needs too serves all.
  void prepare_to_learn() noexcept;
  /// The same of the mean of the frames since the last one that was learnt from, and whether there are any.
  Eigen::Vector3d mean_residual_mm(std::size_t i) noexcept;
  bool has_unlearnt() const noexcept { return summed_ > 0; }
  /// The model's own variance of that prediction, per axis.
  double variance_mm2(std::size_t i) noexcept {
    condition_visible(i);
    return markers_[i].variance_mm2;
  }

  /// What the hidden markers' predictions of the frame before fell by when the last observe() took up other markers to
  /// condition on: a residual remembered under the old ones is to be raised by it. Zero else.
  bool has_shifted() const noexcept { return has_shifted_; }
  const Eigen::Vector3d& shift_mm(std::size_t i) const noexcept { return markers_[i].shift_mm; }

 private:
  struct Marker {
    Eigen::Matrix3d leave_one_out_mm2 = Eigen::Matrix3d::Identity();  ///< variance given the others
    Eigen::Vector3d rest_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
    double variance_mm2 = 0;
    bool seen = false, visible = false;
    bool believed = false;     ///< P holds what is believed of it
    bool conditioned = false;  ///< was visible to condition()
    bool is_left_out = false;  ///< leave_one_out_mm2 is that of what condition() found
    bool whole = false;        ///< visible in all frames since the last one that was learnt from
  };

  static Eigen::Index at(std::size_t i) noexcept { return static_cast<Eigen::Index>(3 * i); }
  auto precision_of(std::size_t i) const noexcept { return precision_.middleCols<3>(at(i)); }
  Eigen::MatrixXd precision_of_kept(const std::vector<int>& old_index) const;
  Eigen::Vector3d residual_of(std::size_t i, const Eigen::VectorXd& deviation_mm) noexcept;
  Eigen::Vector3d deviation_predicted(std::size_t i) noexcept;
  bool is_informative() const noexcept;
  bool conditions_changed() const noexcept;
  void note_predictions() noexcept;
  void note_shifts() noexcept;
  void condition() noexcept;
  void condition_visible(std::size_t i) noexcept;
  void condition_hidden(std::size_t k) noexcept;
  void complete() noexcept;
  double ridge() const noexcept;
  Eigen::Matrix3d believed_mm2(std::size_t i, std::size_t j) const noexcept;
  void believe(std::size_t i) noexcept;
  void believe_newcomers() noexcept;
  void add_square(double keep) noexcept;
  void renew_ridge(double share) noexcept;

  MarkerCovarianceOptions options_;
  KnownModes modes_;
  std::vector<Marker> markers_;
  Eigen::VectorXd deviation_mm_;     ///< from the rest, of the frame last observed; hidden markers as predicted
  Eigen::VectorXd sum_mm_;           ///< of deviations since the last frame that was learnt from
  Eigen::MatrixXd precision_;        ///< P, 1 / mm^2
  Eigen::VectorXd direction_;        ///< of a rank-1 update
  Eigen::VectorXd pull_;             ///< P deviation_mm_, and
  Eigen::VectorXd sum_pull_;         ///< P sum_mm_, while is_prepared_
  std::vector<std::size_t> hidden_;  ///< seen, and hidden from condition()
  std::vector<double> factor_;       ///< lower Cholesky factor of P_hh
  Eigen::MatrixXd reach_;            ///< what is solved with it
  double frames_ = 0;                ///< n, forgotten exponentially
  int summed_ = 0;
  int since_ridge_ = 0;          ///< frames
  Eigen::Index next_ridge_ = 0;  ///< coordinate
  double forgotten_ = 0;         ///< share of the ridge, since one was renewed last
  bool must_condition_ = true, has_shifted_ = false, is_prepared_ = false;
};

}  // namespace risorius
