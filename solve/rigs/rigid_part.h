// The part of a displacement field that a small motion of the head would explain.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// The field (3 x M, mm) of the small rigid motion of `points_mm` (3 x M) that comes nearest to `displacement_mm` (3 x
/// M) in weighted (M, >= 0) squares; zero where the weights do not determine one.
Eigen::Matrix3Xd rigid_part(const Eigen::Matrix3Xd& points_mm, const Eigen::Matrix3Xd& displacement_mm,
                            const Eigen::VectorXd& weight);

}  // namespace risorius
