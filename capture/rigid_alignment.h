// The rigid motion that carries one set of points onto another with least weighted squared distance
// (Horn 1987, unit quaternions). Always a rotation: a registration never mirrors.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

namespace risorius {

/// p_to = rotation * p_from + translation.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const noexcept { return rotation * p + translation; }
  RigidTransform inverse() const noexcept {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
};

struct RigidAlignment {
  RigidTransform to_from;
  double rms = 0;  ///< weighted root mean square distance that remains, unit of the points
  /// The second and third singular value of the weighted point spread (unit of the points): the third may be 0 (flat),
  /// the second must not be (collinear points leave the rotation undetermined).
  double second_spread = 0;
  bool determined = false;  ///< at least 3 weighted points that are not collinear
};

/// Weights >= 0; a point of weight 0 is not read (it may be NaN). Sizes must be equal. Does not allocate.
RigidAlignment align_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                           std::span<const double> weights) noexcept;

}  // namespace risorius
