// One marker's way through a gap, from its own past and future and from the other markers, as a Gaussian process over
// the take:  y(t) = mean + B x(t) + r(t) + noise,  with x the other markers, B one linear map a priori ~ N(0, 1 /
// |x|^2), and r a smooth wandering of its own (two Matern 3/2 kernels, a slow and a quick one). So there is one
// covariance,
//   k(s, t) = 1 + x(s) . x(t) + slow m(|s - t| / slow_s) + quick m(|s - t| / quick_s),   m(u) = (1 + sqrt3 u) e^(-sqrt3
//   u),
// and the fill is its conditional mean given the samples around the gap and some from the whole take; close to an end
// r carries the marker's own residual into the gap, far from it B decides. How much of either is believed is not set
// but learnt: of several kernels the one under which the marker's own samples are likeliest (marginal likelihood), with
// the scale profiled out. The stated variance is the conditional one.
// Where somebody knows the face (a rig), B is a priori not around nothing but around what is known: y less a share of
// that guess, the share chosen in the same way.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace risorius {

/// Parts of a marker's variance, and time constants.
struct GapKernel {
  double slow, slow_s, quick, quick_s, rough;
};

/// What was found likeliest.
struct GapChoice {
  GapKernel kernel;
  double guess_share;
};

/// What is known at some frames, one column each.
struct GapFeatures {
  Eigen::MatrixXd others;     ///< where the other markers are, weighted as they shall count
  Eigen::VectorXd time_s;     ///< of the frames
  Eigen::Matrix3Xd guess_mm;  ///< by how much the marker is displaced, by somebody who knows it; or no columns
};

class GapRegression {
 public:
  struct Fill {
    Eigen::Matrix3Xd position_mm;  ///< one column per frame asked for
    Eigen::VectorXd variance_mm2;  ///< per axis
  };

  /// `position_mm`: the samples, one column each, with what is known of their frames. noise_mm: of a sample, per axis.
  /// At least one sample.
  GapRegression(GapFeatures known, const Eigen::Matrix3Xd& position_mm, double noise_mm);

  /// With a choice made elsewhere.
  GapRegression(GapFeatures known, const Eigen::Matrix3Xd& position_mm, double noise_mm, const GapChoice& choice);

  GapChoice choice() const noexcept { return {kernel_, guess_share_}; }
  /// There is a guess if there was one of the samples.
  Fill fill(const GapFeatures& hidden) const;

 private:
  GapRegression(const Eigen::Matrix3Xd& position_mm, double noise_mm, GapFeatures known);
  double covariance(double product, double apart_s) const noexcept;
  /// Log likelihood of the samples under kernel_, with the best scale; keeps the factor.
  double factorize(const Eigen::MatrixXd& products);

  void subtract_guess(double share);
  Eigen::MatrixXd products() const { return feature_scale_ * (known_.others.transpose() * known_.others); }

  GapFeatures known_;
  Eigen::Matrix3Xd position_mm_;
  Eigen::Vector3d mean_mm_;
  Eigen::MatrixXd centred_mm_;  ///< samples x 3
  double guess_share_ = 0;
  double noise_mm2_, nugget_ = 0, feature_scale_;
  GapKernel kernel_{};
  double scale_ = 1;
  Eigen::MatrixXd factor_;  ///< lower Cholesky factor
};

}  // namespace risorius
