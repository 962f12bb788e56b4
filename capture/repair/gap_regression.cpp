#include "capture/repair/gap_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace risorius {
namespace {

/// From markers that the others explain to 2 % of their variance to such as go their own way.
constexpr std::array<GapKernel, 8> kKernels{{{0.02, 0.3, 0.004, 0.06, 0.001},
                                             {0.1, 0.3, 0.01, 0.06, 0.001},
                                             {0.3, 0.3, 0.03, 0.06, 0.001},
                                             {1, 0.3, 0.06, 0.06, 0.001},
                                             {0.02, 1, 0.004, 0.1, 0.001},
                                             {0.1, 1, 0.01, 0.1, 0.001},
                                             {0.3, 1, 0.03, 0.1, 0.001},
                                             {1, 1, 0.06, 0.1, 0.001}}};
constexpr double kLeastVarianceMm2 = 1e-4;
/// Of what somebody who knows the face says. Half of it: a rig that was not made of this take is wrong by a good part,
/// and the samples would rather believe all of it than none.
constexpr std::array kGuessShares{0.0, 0.5};
/// Keeps the factorization sound where the samples are exact.
constexpr double kLeastNugget = 1e-6;

double matern(double u) noexcept {
  const double scaled = std::sqrt(3.0) * u;
  return (1 + scaled) * std::exp(-scaled);
}

}  // namespace

/// Without a factor yet.
GapRegression::GapRegression(const Eigen::Matrix3Xd& position_mm, double noise_mm, GapFeatures known)
    : known_(std::move(known)), position_mm_(position_mm), noise_mm2_(noise_mm * noise_mm) {
  const double energy = known_.others.squaredNorm() / static_cast<double>(position_mm.cols());
  feature_scale_ = energy > 0 ? 1 / energy : 0;
}

GapRegression::GapRegression(GapFeatures known, const Eigen::Matrix3Xd& position_mm, double noise_mm,
                             const GapChoice& choice)
    : GapRegression(position_mm, noise_mm, std::move(known)) {
  kernel_ = choice.kernel;
  subtract_guess(choice.guess_share);
  factorize(products());
}

GapRegression::GapRegression(GapFeatures known, const Eigen::Matrix3Xd& position_mm, double noise_mm)
    : GapRegression(position_mm, noise_mm, std::move(known)) {
  const Eigen::MatrixXd by_others = products();
  double best = -std::numeric_limits<double>::infinity();
  GapChoice likeliest{kKernels.front(), 0};
  for (const double share : kGuessShares) {
    if (share > 0 && known_.guess_mm.cols() == 0) continue;
    subtract_guess(share);
    for (const GapKernel& candidate : kKernels) {
      kernel_ = candidate;
      const double likelihood = factorize(by_others);
      if (likelihood > best) best = likelihood, likeliest = choice();
    }
  }
  subtract_guess(likeliest.guess_share);
  kernel_ = likeliest.kernel;
  factorize(by_others);
}

void GapRegression::subtract_guess(double share) {
  guess_share_ = share;
  Eigen::Matrix3Xd rest_mm = position_mm_;
  if (share > 0) rest_mm -= share * known_.guess_mm;
  mean_mm_ = rest_mm.rowwise().mean();
  centred_mm_ = (rest_mm.colwise() - mean_mm_).transpose();
  const auto samples = static_cast<double>(centred_mm_.rows());
  const double variance_mm2 = std::max(centred_mm_.squaredNorm() / (3 * samples), kLeastVarianceMm2);
  nugget_ = std::max(noise_mm2_ / variance_mm2, kLeastNugget);
}

double GapRegression::covariance(double product, double apart_s) const noexcept {
  const double apart = std::abs(apart_s);
  return 1 + product + kernel_.slow * matern(apart / kernel_.slow_s) + kernel_.quick * matern(apart / kernel_.quick_s);
}

double GapRegression::factorize(const Eigen::MatrixXd& products) {
  const Eigen::Index n = products.rows();
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    for (Eigen::Index r = c; r < n; ++r) k(r, c) = covariance(products(r, c), known_.time_s[r] - known_.time_s[c]);
    k(c, c) += nugget_ + kernel_.rough;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(k);  // in place
  const Eigen::MatrixXd white = k.triangularView<Eigen::Lower>().solve(centred_mm_);
  const auto samples = static_cast<double>(n);
  scale_ = std::max(white.squaredNorm() / (3 * samples), kLeastVarianceMm2);
  const double log_determinant = 2 * k.diagonal().array().log().sum();
  factor_ = std::move(k);
  return -1.5 * (samples * std::log(scale_) + log_determinant);
}

GapRegression::Fill GapRegression::fill(const GapFeatures& hidden) const {
  Eigen::MatrixXd cross = feature_scale_ * (known_.others.transpose() * hidden.others);
  Eigen::VectorXd own(hidden.time_s.size());
  for (Eigen::Index c = 0; c < cross.cols(); ++c) {
    for (Eigen::Index r = 0; r < cross.rows(); ++r) {
      cross(r, c) = covariance(cross(r, c), known_.time_s[r] - hidden.time_s[c]);
    }
    own[c] = covariance(feature_scale_ * hidden.others.col(c).squaredNorm(), 0) + kernel_.rough;
  }
  const auto lower = factor_.triangularView<Eigen::Lower>();
  const Eigen::MatrixXd reach = lower.solve(cross);
  const Eigen::MatrixXd white = lower.solve(centred_mm_);
  Fill fill;
  fill.position_mm = (white.transpose() * reach).colwise() + mean_mm_;
  if (guess_share_ > 0) fill.position_mm += guess_share_ * hidden.guess_mm;
  fill.variance_mm2 = scale_ * (own - reach.colwise().squaredNorm().transpose()).cwiseMax(kLeastNugget);
  return fill;
}

}  // namespace risorius
