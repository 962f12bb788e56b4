#include "solve/rigs/rigid_part.h"

#include <Eigen/Cholesky>

#include "solve/rigs/stabilisers.h"

namespace risorius {
namespace {

using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// d p / d (translation, rotation vector) of a point that moves with the head.
Matrix36 motion_at(const Eigen::Vector3d& p) {
  Matrix36 j;
  j << Eigen::Matrix3d::Identity(), Eigen::Matrix3d{{0, p.z(), -p.y()}, {-p.z(), 0, p.x()}, {p.y(), -p.x(), 0}};
  return j;
}

}  // namespace

Eigen::Matrix3Xd rigid_part(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3Xd& displacement_mm,
                            const Eigen::VectorXd& weight) {
  Eigen::Matrix3Xd field = Eigen::Matrix3Xd::Zero(3, points_mm.cols());
  if (!hold_still(points_mm, weight)) return field;
  const Eigen::Vector3d centre = points_mm.rowwise().mean();  // far from the origin, turns and shifts look alike
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  for (Eigen::Index m = 0; m < points_mm.cols(); ++m) {
    if (!(weight[m] > 0)) continue;
    const Matrix36 j = motion_at(points_mm.col(m) - centre);
    normal += weight[m] * j.transpose() * j;
    right += weight[m] * j.transpose() * displacement_mm.col(m);
  }
  const Eigen::Matrix<double, 6, 1> motion = normal.ldlt().solve(right);
  for (Eigen::Index m = 0; m < points_mm.cols(); ++m) field.col(m) = motion_at(points_mm.col(m) - centre) * motion;
  return field;
}

}  // namespace risorius
