// The rig's displacement fields as one matrix, and its weighted Gram matrix. With e_im the 3-vector by which AU i moves
// marker m, and weights w_m per marker:
//     H(w) = sum_m w_m G_m,   (G_m)_ij = e_im . e_jm,      b(w) = sum_m w_m e_m' y_m.
// H is cached at the usual weights; a frame adds (w_m - usual_m) G_m for the markers that differ, as rank-3 updates
// (cheaper than reading stored G_m, which do not fit the cache), or sums anew where most differ.
#pragma once

#include <Eigen/Core>

#include "solve/rigs/rig.h"

namespace risorius {

class MarkerBasis {
 public:
  /// The usual weights are all 1.
  explicit MarkerBasis(const Rig& rig);

  Eigen::Index marker_count() const noexcept { return rows_.cols() / 3; }
  Eigen::Index au_count() const noexcept { return rows_.rows(); }
  /// Mean of the diagonal of H(1), in mm^2: the measure of the penalties.
  double mean_diagonal_mm2() const noexcept { return mean_diagonal_mm2_; }

  /// The weights (M) at which the Gram matrix is cached.
  void use_weights(const Eigen::VectorXd& usual) noexcept;
  /// H(weight), K x K; equal bits for equal weights.
  void gram(const Eigen::VectorXd& weight, Eigen::MatrixXd& h) const noexcept;
  /// b = sum over markers of e_m' v_m; `v_mm` (3M) is already weighted.
  void project(const Eigen::VectorXd& v_mm, Eigen::VectorXd& b) const noexcept;
  /// The displacements (3M) at intensities x (K).
  void deform(const Eigen::VectorXd& x, Eigen::VectorXd& displacement_mm) const noexcept;
  /// The share (K, 0 to 1) of each AU's displacement energy that is visible under the weights.
  void visible_share(const Eigen::VectorXd& weight, Eigen::VectorXd& share) const noexcept;
  /// Whether any AU moves marker m.
  bool moves(Eigen::Index m) const noexcept { return energy_share_.col(m).maxCoeff() > 0; }

 private:
  void add_marker(Eigen::Index m, double weight, Eigen::MatrixXd& h) const noexcept;

  Eigen::MatrixXd rows_;          // K x 3M: column 3m+a holds axis a of marker m for all AUs
  Eigen::MatrixXd energy_share_;  // K x M
  Eigen::MatrixXd usual_gram_;    // K x K, lower triangle
  Eigen::VectorXd usual_weight_;
  double mean_diagonal_mm2_ = 0;
};

}  // namespace risorius
