#include "capture/rigid_alignment.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "capture/check.h"

namespace risorius {
namespace {

/// Two points, or points on one line, leave a rotation about that line free.
constexpr double kCollinearSpreadRatio = 1e-3;
/// Of Newton's method from above; a mirrored or very poor fit, far from the bound, is left to the full decomposition.
constexpr int kNewtonSteps = 20;
constexpr double kNewtonTolerance = 1e-13;
/// In units of the bound (cubed): the product of the gaps between eigenvalues below which the adjugate is rounding.
constexpr double kLeastGap = 1e-8;
constexpr double kEigenvectorTolerance = 1e-14;
/// Of a difference of squares this small, as a share of them, the last digits are rounding.
constexpr double kCancellation = 1e-6;

/// Horn's symmetric matrix N, whose largest eigenvector is the quaternion (w, x, y, z).
Eigen::Matrix4d horn_matrix(const Eigen::Matrix3d& s) noexcept {
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0), s(1, 2) - s(2, 1),
      s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2), s(2, 0) - s(0, 2), s(0, 1) + s(1, 0),
      -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1), s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1),
      -s(0, 0) - s(1, 1) + s(2, 2);
  return n;
}

/// The column of the adjugate of the symmetric a with the greatest diagonal: parallel to the null vector where a is
/// singular of rank 3. By 2 x 2 minors of the upper and lower two rows.
Eigen::Vector4d adjugate_column(const Eigen::Matrix4d& a) noexcept {
  const double s0 = a(0, 0) * a(1, 1) - a(1, 0) * a(0, 1), s1 = a(0, 0) * a(1, 2) - a(1, 0) * a(0, 2),
               s2 = a(0, 0) * a(1, 3) - a(1, 0) * a(0, 3), s3 = a(0, 1) * a(1, 2) - a(1, 1) * a(0, 2),
               s4 = a(0, 1) * a(1, 3) - a(1, 1) * a(0, 3), s5 = a(0, 2) * a(1, 3) - a(1, 2) * a(0, 3);
  const double c5 = a(2, 2) * a(3, 3) - a(3, 2) * a(2, 3), c4 = a(2, 1) * a(3, 3) - a(3, 1) * a(2, 3),
               c3 = a(2, 1) * a(3, 2) - a(3, 1) * a(2, 2), c2 = a(2, 0) * a(3, 3) - a(3, 0) * a(2, 3),
               c1 = a(2, 0) * a(3, 2) - a(3, 0) * a(2, 2);
  const Eigen::Vector4d diagonal(a(1, 1) * c5 - a(1, 2) * c4 + a(1, 3) * c3, a(0, 0) * c5 - a(0, 2) * c2 + a(0, 3) * c1,
                                 a(3, 0) * s4 - a(3, 1) * s2 + a(3, 3) * s0,
                                 a(2, 0) * s3 - a(2, 1) * s1 + a(2, 2) * s0);
  const double a01 = -a(0, 1) * c5 + a(0, 2) * c4 - a(0, 3) * c3, a02 = a(3, 1) * s5 - a(3, 2) * s4 + a(3, 3) * s3,
               a03 = -a(2, 1) * s5 + a(2, 2) * s4 - a(2, 3) * s3, a12 = -a(3, 0) * s5 + a(3, 2) * s2 - a(3, 3) * s1,
               a13 = a(2, 0) * s5 - a(2, 2) * s2 + a(2, 3) * s1, a23 = -a(2, 0) * s4 + a(2, 1) * s2 - a(2, 3) * s0;
  int greatest = 0;
  diagonal.cwiseAbs().maxCoeff(&greatest);
  switch (greatest) {
    case 0:
      return {diagonal[0], a01, a02, a03};
    case 1:
      return {a01, diagonal[1], a12, a13};
    case 2:
      return {a02, a12, diagonal[2], a23};
    default:
      return {a03, a13, a23, diagonal[3]};
  }
}

/// The eigenvector of the greatest eigenvalue of Horn's matrix. `bound` is at least that eigenvalue and, where the fit
/// is good, near it: Newton on the characteristic polynomial falls from there to its greatest root (Theobald 2005), and
/// a Rayleigh quotient takes away what rounding the polynomial added. Where the two greatest eigenvalues are too near
/// each other for that, the full decomposition decides.
Eigen::Vector4d greatest_eigenvector(const Eigen::Matrix4d& n, double bound) noexcept {
  const Eigen::Matrix4d n2 = n.lazyProduct(n);
  // det(x I - n) = x^4 + p2 x^2 + p1 x + p0, by Newton's identities; the trace of n is 0.
  const double t2 = n2.trace(), t3 = n2.cwiseProduct(n).sum(), t4 = n2.squaredNorm();
  const double p2 = -t2 / 2, p1 = -t3 / 3, p0 = (t2 * t2 / 2 - t4) / 4;
  double x = bound;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double slope = (4 * x * x + 2 * p2) * x + p1;
    if (!(slope > 0)) break;
    const double change = (((x * x + p2) * x + p1) * x + p0) / slope;
    x -= change;
    if (std::abs(change) <= kNewtonTolerance * bound) break;
  }
  for (int polish = 0; polish < 2; ++polish) {
    const Eigen::Vector4d v = adjugate_column(n - x * Eigen::Matrix4d::Identity());
    const double size = v.norm();
    if (!(size > kLeastGap * bound * bound * bound)) break;
    const Eigen::Vector4d q = v / size;
    const Eigen::Vector4d nq = n.lazyProduct(q);
    x = q.dot(nq);
    if ((nq - x * q).norm() <= kEigenvectorTolerance * bound) return q;
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(n).eigenvectors().col(3);
}

Eigen::Vector3d ascending_eigenvalues(const Eigen::Matrix3d& symmetric) noexcept {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

/// Weighted first and second moments of two sets of points about an origin each.
struct Moments {
  double total = 0;
  int used = 0;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero(), from_from = Eigen::Matrix3d::Zero(), to_to = Eigen::Matrix3d::Zero();
};

/// A block of points, each axis on its own: so the sums are dot products of whole registers.
struct Block {
  static constexpr Eigen::Index kSize = 64;
  Eigen::Matrix<double, kSize, 3> from, to;
  Eigen::Matrix<double, kSize, 1> weight;
  Eigen::Index size = 0;

  void add_to(Moments& moments) noexcept {
    // Padded with weight 0: fixed sizes need no loops over remainders.
    weight.tail(kSize - size).setZero();
    from.bottomRows(kSize - size).setZero();
    to.bottomRows(kSize - size).setZero();
    moments.total += weight.sum();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Matrix<double, kSize, 1> weighted_from = from.col(i).cwiseProduct(weight),
                                            weighted_to = to.col(i).cwiseProduct(weight);
      moments.from[i] += weighted_from.sum();
      moments.to[i] += weighted_to.sum();
      for (int j = 0; j < 3; ++j) moments.cross(i, j) += weighted_from.dot(to.col(j));
      for (int j = 0; j <= i; ++j) {
        moments.from_from(i, j) += weighted_from.dot(from.col(j));
        moments.to_to(i, j) += weighted_to.dot(to.col(j));
      }
    }
    size = 0;
  }
};

/// About the first point that counts, which is near enough to the mean for nothing to cancel.
Moments moments_of(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                   std::span<const double> weights, Eigen::Vector3d& from_origin, Eigen::Vector3d& to_origin) noexcept {
  Moments moments;
  Block block;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    if (moments.used++ == 0) from_origin = from[i], to_origin = to[i];
    block.from.row(block.size) = from[i] - from_origin;
    block.to.row(block.size) = to[i] - to_origin;
    block.weight[block.size] = weights[i];
    if (++block.size == Block::kSize) block.add_to(moments);
  }
  if (block.size > 0) block.add_to(moments);
  return moments;
}

}  // namespace

RigidAlignment align_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                           std::span<const double> weights) noexcept {
  RISORIUS_CHECK(from.size() == to.size() && from.size() == weights.size());
  RigidAlignment result;
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = Eigen::Vector3d::Zero();
  const Moments moments = moments_of(from, to, weights, from_mean, to_mean);
  if (moments.used == 0) return result;
  const double total = moments.total;
  const int used = moments.used;
  const Eigen::Vector3d a = moments.from / total, b = moments.to / total;
  from_mean += a;
  to_mean += b;
  const Eigen::Matrix3d cross = moments.cross - total * a * b.transpose();
  const Eigen::Matrix3d from_from = moments.from_from.selfadjointView<Eigen::Lower>();
  const Eigen::Matrix3d to_to = moments.to_to.selfadjointView<Eigen::Lower>();
  const Eigen::Matrix3d spread = from_from - total * a * a.transpose();
  const Eigen::Matrix3d seen_spread = to_to - total * b * b.transpose();

  const Eigen::Vector3d spread_eigen = ascending_eigenvalues(spread / total);
  const Eigen::Vector3d seen_eigen = ascending_eigenvalues(seen_spread / total);
  const auto collinear = [](const Eigen::Vector3d& squared) {
    return !(std::sqrt(std::max(0.0, squared[1])) > kCollinearSpreadRatio * std::sqrt(std::max(0.0, squared[2])));
  };
  result.second_spread = std::sqrt(std::max(0.0, spread_eigen[1]));
  result.determined = used >= 3 && !collinear(spread_eigen) && !collinear(seen_eigen);

  // Without a rotation that fits best, none.
  const double bound = (spread.trace() + seen_spread.trace()) / 2;
  const Eigen::Matrix4d horn = horn_matrix(cross);
  const Eigen::Vector4d q = result.determined ? greatest_eigenvector(horn, bound) : Eigen::Vector4d(1, 0, 0, 0);
  result.to_from.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  if (result.to_from.rotation.w() < 0) result.to_from.rotation.coeffs() *= -1;
  result.to_from.translation = to_mean - result.to_from.rotation * from_mean;

  // Of squares that nearly cancel little is right: then they are summed one by one.
  double squared = 2 * (bound - q.dot(horn * q));
  if (!(squared > kCancellation * bound)) {
    squared = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (weights[i] > 0) squared += weights[i] * (result.to_from * from[i] - to[i]).squaredNorm();
    }
  }
  result.rms = std::sqrt(squared / total);
  return result;
}

}  // namespace risorius
