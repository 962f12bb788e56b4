// The similarity (rotation, translation, one positive scale) that carries one set of points onto another with least
// weighted squared distance (Umeyama 1991). It never mirrors.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace risorius {

/// p_to = scale * rotation * p_from + translation.
struct Similarity {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const noexcept { return scale * (rotation * p) + translation; }
  Similarity inverse() const noexcept {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation) / scale, 1 / scale};
  }
};

struct SimilarityFit {
  Similarity to_from;
  double rms = 0;           ///< weighted root mean square distance that remains, unit of `to`
  bool determined = false;  ///< at least 3 weighted points that are not collinear
};

/// Points 3 x N, weights N, >= 0; all finite.
SimilarityFit fit_similarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to, const Eigen::VectorXd& weights);

}  // namespace risorius
