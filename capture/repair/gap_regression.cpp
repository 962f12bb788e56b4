#include "capture/repair/gap_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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
/// Keeps the factorization sound where the samples are exact.
constexpr double kLeastNugget = 1e-6;

double matern(double u) noexcept {
  const double scaled = std::sqrt(3.0) * u;
  return (1 + scaled) * std::exp(-scaled);
}

}  // namespace

GapRegression::GapRegression(const Eigen::MatrixXd& features, const Eigen::VectorXd& time_s,
                             const Eigen::Matrix3Xd& position_mm, double noise_mm)
    : features_(features), time_s_(time_s), mean_mm_(position_mm.rowwise().mean()) {
  centred_mm_ = (position_mm.colwise() - mean_mm_).transpose();
  const auto samples = static_cast<double>(position_mm.cols());
  variance_mm2_ = std::max(centred_mm_.squaredNorm() / (3 * samples), kLeastVarianceMm2);
  nugget_ = std::max(noise_mm * noise_mm / variance_mm2_, kLeastNugget);
  const double energy = features_.squaredNorm() / samples;
  feature_scale_ = energy > 0 ? 1 / energy : 0;
  const Eigen::MatrixXd products = feature_scale_ * (features_.transpose() * features_);
  double best = -std::numeric_limits<double>::infinity();
  GapKernel likeliest = kKernels.front();
  for (const GapKernel& candidate : kKernels) {
    kernel_ = candidate;
    const double likelihood = factorize(products);
    if (likelihood > best) best = likelihood, likeliest = candidate;
  }
  kernel_ = likeliest;
  factorize(products);
}

double GapRegression::covariance(double product, double apart_s) const noexcept {
  const double apart = std::abs(apart_s);
  return 1 + product + kernel_.slow * matern(apart / kernel_.slow_s) + kernel_.quick * matern(apart / kernel_.quick_s);
}

double GapRegression::factorize(const Eigen::MatrixXd& products) {
  const Eigen::Index n = products.rows();
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    for (Eigen::Index r = c; r < n; ++r) k(r, c) = covariance(products(r, c), time_s_[r] - time_s_[c]);
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

GapRegression::Fill GapRegression::fill(const Eigen::MatrixXd& features, const Eigen::VectorXd& time_s) const {
  Eigen::MatrixXd cross = feature_scale_ * (features_.transpose() * features);
  Eigen::VectorXd own(time_s.size());
  for (Eigen::Index c = 0; c < cross.cols(); ++c) {
    for (Eigen::Index r = 0; r < cross.rows(); ++r) cross(r, c) = covariance(cross(r, c), time_s_[r] - time_s[c]);
    own[c] = covariance(feature_scale_ * features.col(c).squaredNorm(), 0) + kernel_.rough;
  }
  const auto lower = factor_.triangularView<Eigen::Lower>();
  const Eigen::MatrixXd reach = lower.solve(cross);
  const Eigen::MatrixXd white = lower.solve(centred_mm_);
  Fill fill;
  fill.position_mm = (white.transpose() * reach).colwise() + mean_mm_;
  fill.variance_mm2 = scale_ * (own - reach.colwise().squaredNorm().transpose()).cwiseMax(kLeastNugget);
  return fill;
}

}  // namespace risorius
