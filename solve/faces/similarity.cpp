#include "solve/faces/similarity.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace risorius {

SimilarityFit fit_similarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, const Eigen::VectorXd& weights) {
  SimilarityFit fit;
  const double weight_sum = weights.sum();
  if (!(weight_sum > 0)) return fit;
  const Eigen::VectorXd share = weights / weight_sum;
  const Eigen::Vector3d from_mean = from * share, to_mean = to * share;
  const Eigen::Matrix3Xd from_centred = from.colwise() - from_mean;
  const Eigen::Matrix3Xd to_centred = to.colwise() - to_mean;
  const double from_variance = from_centred.colwise().squaredNorm() * share;
  const Eigen::Matrix3d covariance = to_centred * share.asDiagonal() * from_centred.transpose();  // eq. (38)
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d spread = svd.singularValues();
  if (!(spread[1] > 1e-9 * spread[0])) return fit;

  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign[2] = -1;  // eq. (39), (43)
  Similarity& similarity = fit.to_from;
  const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();  // eq. (40)
  similarity.rotation = Eigen::Quaterniond(rotation).normalized();
  similarity.scale = spread.dot(sign) / from_variance;                                      // eq. (42)
  similarity.translation = to_mean - similarity.scale * (similarity.rotation * from_mean);  // eq. (41)
  const Eigen::Matrix3Xd moved = similarity.scale * similarity.rotation.toRotationMatrix() * from_centred;
  fit.rms = std::sqrt((to_centred - moved).colwise().squaredNorm() * share);
  fit.determined = similarity.scale > 0;
  return fit;
}

}  // namespace risorius
