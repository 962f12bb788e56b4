#include "capture/rigid_alignment.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "capture/check.h"

namespace risorius {
namespace {

/// Two points, or points on one line, leave a rotation about that line free.
constexpr double kCollinearSpreadRatio = 1e-3;

/// Horn's symmetric matrix N, whose largest eigenvector is the quaternion (w, x, y, z).
Eigen::Matrix4d horn_matrix(const Eigen::Matrix3d& s) noexcept {
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0), s(1, 2) - s(2, 1),
      s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2), s(2, 0) - s(0, 2), s(0, 1) + s(1, 0),
      -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1), s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1),
      -s(0, 0) - s(1, 1) + s(2, 2);
  return n;
}

}  // namespace

RigidAlignment align_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                           std::span<const double> weights) noexcept {
  RISORIUS_CHECK(from.size() == to.size() && from.size() == weights.size());
  RigidAlignment result;
  double total = 0;
  int used = 0;
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    total += weights[i];
    ++used;
    from_mean += weights[i] * from[i];
    to_mean += weights[i] * to[i];
  }
  if (used == 0) return result;
  from_mean /= total;
  to_mean /= total;

  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero(),
                  seen_spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    const Eigen::Vector3d a = from[i] - from_mean, b = to[i] - to_mean;
    cross += weights[i] * a * b.transpose();
    spread += weights[i] * a * a.transpose();
    seen_spread += weights[i] * b * b.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread_eigen(spread / total, Eigen::EigenvaluesOnly);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> seen_eigen(seen_spread / total, Eigen::EigenvaluesOnly);
  const auto collinear = [](const Eigen::Vector3d& squared) {
    return !(std::sqrt(std::max(0.0, squared[1])) > kCollinearSpreadRatio * std::sqrt(std::max(0.0, squared[2])));
  };
  result.second_spread = std::sqrt(std::max(0.0, spread_eigen.eigenvalues()[1]));
  result.determined = used >= 3 && !collinear(spread_eigen.eigenvalues()) && !collinear(seen_eigen.eigenvalues());

  if (result.determined) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(horn_matrix(cross));
    const Eigen::Vector4d q = eigen.eigenvectors().col(3);
    result.to_from.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
    if (result.to_from.rotation.w() < 0) result.to_from.rotation.coeffs() *= -1;
  }
  result.to_from.translation = to_mean - result.to_from.rotation * from_mean;

  double squared = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (weights[i] > 0) squared += weights[i] * (result.to_from * from[i] - to[i]).squaredNorm();
  }
  result.rms = std::sqrt(squared / total);
  return result;
}

}  // namespace risorius
