// The regularised least-squares update of a rig's basis, given intensities (Choe & Ko 2001; Bouaziz et al. 2013):
// displacement fields e_im and a shift n_m of the neutral that minimise
//     sum_t c_t / s^2 sum_m w_tm || y_tm - n_m - sum_i x_ti e_im ||^2 + sum_i || e_i - e0_i ||^2_(C_i) + ||n||^2 /
//     s_n^2
// with y the displacement from the start's neutral in the head frame. C_i says how an AU may differ from one person to
// the next: by a share of what it does there or close by, and neighbouring markers together,
//     C_i(m, m') = s_im s_im' ((1 - g) exp(-d^2 / 2 l^2) + g [m = m']),   s_im = share * reach_im + floor * peak_i.
// The priors stand around the START of a refinement, not around its last round: rounds cannot add up to a drift.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

struct BasisPrior {
  double share = 0.3;          ///< of an AU's own displacement, one standard deviation, > 0
  double floor = 0.03;         ///< of the AU's largest displacement, anywhere on the face, > 0
  double reach_mm = 12;        ///< how far beyond the markers that it moves an AU may move others, > 0
  double correlation_mm = 60;  ///< neighbours closer than this change together, > 0
  double own_share = 0.25;     ///< of the variance that is each marker's own, (0, 1]
  double neutral_mm = 0.5;     ///< standard deviation of the neutral, per axis; 0 = keep the neutral
};

/// How far (mm) AU i reaches at each marker (M): its largest displacement nearby, falling with the distance.
Eigen::VectorXd reach_of(const Rig& rig, const RigAu& au, double reach_mm);

/// What frames say about the basis, in sums.
class BasisEvidence {
 public:
  BasisEvidence(std::size_t marker_count, std::size_t au_count);

  /// Intensities x (K) and their covariance for a noise of 1 mm (K x K), displacements from the neutral y (3 x M, not
  /// read where the weight is 0), weights w (M, >= 0) and the frame's own weight c > 0.
  void add(const Eigen::VectorXd& x, const Eigen::MatrixXd& unit_covariance, const Eigen::Matrix3Xd& y_mm,
           const Eigen::VectorXd& weight, double frame_weight);

  /// Of marker m: sum c w [1; x] [1; x]' and sum c w [1; x] y'.
  const Eigen::MatrixXd& gram(std::size_t m) const noexcept { return gram_[m]; }
  /// Of marker m: sum c w cov, K x K.
  const Eigen::MatrixXd& doubt(std::size_t m) const noexcept { return doubt_[m]; }
  const Eigen::MatrixXd& target(std::size_t m) const noexcept { return target_[m]; }
  std::size_t marker_count() const noexcept { return gram_.size(); }
  std::size_t au_count() const noexcept { return static_cast<std::size_t>(gram_.front().rows()) - 1; }

 private:
  std::vector<Eigen::MatrixXd> gram_;    // M of (K+1) x (K+1); row 0 is the neutral
  std::vector<Eigen::MatrixXd> target_;  // M of (K+1) x 3
  std::vector<Eigen::MatrixXd> doubt_;   // M of K x K
  Eigen::VectorXd row_;
};

/// The start with new fields and neutral. `noise_mm` > 0: what the model leaves of a marker, per axis. AUs whose entry
/// in `free` (K) is 0 stay as they are.
Rig update_basis(const Rig& start, const BasisEvidence& evidence, const BasisPrior& prior, double noise_mm,
                 const std::vector<char>& free);

/// Throws std::invalid_argument naming the option, its value and its range.
void validate(const BasisPrior& prior);

}  // namespace risorius
