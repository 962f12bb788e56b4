#include "solve/faces/identity_warp.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace risorius {
namespace {

Eigen::Vector3d mirrored(const Eigen::Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

double bell(const Eigen::Vector3d& offset_mm, double length_mm) {
  return std::exp(-0.5 * offset_mm.squaredNorm() / (length_mm * length_mm));
}

}  // namespace

// With k the bell times the variance and S the mirroring, the covariance of the displacements at p and q is
// k(p, q) I + k(p, Sq) S.
IdentityWarp::IdentityWarp(const std::vector<WarpObservation>& observations, const IdentityPrior& prior)
    : length_mm_(prior.length_mm) {
  const auto count = static_cast<Eigen::Index>(observations.size());
  const double variance = prior.deviation_mm * prior.deviation_mm;
  Eigen::MatrixXd covariance(count, count);
  Eigen::VectorXd shifts(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const WarpObservation& a = observations[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      const WarpObservation& b = observations[static_cast<std::size_t>(j)];
      covariance(i, j) =
          variance * (bell(a.at_mm - b.at_mm, length_mm_) * a.direction.dot(b.direction) +
                      bell(a.at_mm - mirrored(b.at_mm), length_mm_) * a.direction.dot(mirrored(b.direction)));
    }
    covariance(i, i) += a.deviation_mm * a.deviation_mm;
    shifts[i] = a.shift_mm;
  }
  const Eigen::VectorXd weights = covariance.selfadjointView<Eigen::Lower>().ldlt().solve(shifts);
  centres_mm_.resize(3, 2 * count);
  pulls_mm_.resize(3, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const WarpObservation& a = observations[static_cast<std::size_t>(i)];
    centres_mm_.col(2 * i) = a.at_mm;
    centres_mm_.col(2 * i + 1) = mirrored(a.at_mm);
    pulls_mm_.col(2 * i) = variance * weights[i] * a.direction;
    pulls_mm_.col(2 * i + 1) = variance * weights[i] * mirrored(a.direction);
  }
}

Eigen::Vector3d IdentityWarp::displacement_mm(const Eigen::Vector3d& p_mm) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index c = 0; c < centres_mm_.cols(); ++c)
    sum += bell(p_mm - centres_mm_.col(c), length_mm_) * pulls_mm_.col(c);
  return sum;
}

Eigen::Matrix3d IdentityWarp::jacobian(const Eigen::Vector3d& p_mm) const noexcept {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  for (Eigen::Index c = 0; c < centres_mm_.cols(); ++c) {
    const Eigen::Vector3d offset_mm = p_mm - centres_mm_.col(c);
    result -= bell(offset_mm, length_mm_) / (length_mm_ * length_mm_) * pulls_mm_.col(c) * offset_mm.transpose();
  }
  return result;
}

}  // namespace risorius
