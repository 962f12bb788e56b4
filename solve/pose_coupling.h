// How a small motion of the head and the AUs trade off: with the markers' Jacobian at the neutral under a rotation
// omega (rad) about the face's centre and a translation tau (mm),
//     e_m(x) + J_m d - y_m,   J_m = [ [E0_m - centre]_x, -I ],   d = (omega, tau),
// the blocks  C = sum_m v_m e_m' J_m (K x 6),  P = sum_m v_m J_m' J_m (6 x 6),  a = sum_m v_m J_m' y_m.  A joint step
// over (x, d) is a step over x alone with H - C P^-1 C' and b - C P^-1 a, and then d = P^-1 (a - C' x).
// C and P are cached at the usual weights and changed by the markers that differ.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "capture/rigid_alignment.h"
#include "solve/rigs/rig.h"

namespace risorius {

class PoseCoupling {
 public:
  explicit PoseCoupling(const Rig& rig);

  void use_neutral(const Rig& rig) noexcept;
  /// The weights (M) at which the blocks are cached.
  void use_weights(const Eigen::VectorXd& usual) noexcept;

  /// C, P and its factor at these weights (M); false if they do not determine a pose.
  bool prepare(const Eigen::VectorXd& weight) noexcept;
  /// a, from displacements (3M) that are already weighted.
  void project(const Eigen::VectorXd& weighted_y_mm) noexcept;
  const Eigen::Matrix<double, Eigen::Dynamic, 6>& c() const noexcept { return c_; }
  const Eigen::Matrix<double, 6, 6>& p() const noexcept { return p_; }
  const Eigen::Matrix<double, 6, 1>& a() const noexcept { return a_; }
  /// H -= C P^-1 C';  b -= C P^-1 a.
  void reduce_hessian(Eigen::MatrixXd& h) const noexcept;
  void reduce_gradient(Eigen::VectorXd& b) const noexcept;
  /// The head's best step d at intensities x, applied to `head_from_world`. Returns how far it moves the face, mm.
  double move_head(const Eigen::VectorXd& x, RigidTransform& head_from_world) const noexcept;
  /// The same for a step d that is known.
  double move_head_by(const Eigen::Matrix<double, 6, 1>& step, RigidTransform& head_from_world) const noexcept;
  /// Root mean square distance of the neutral's markers from their centre.
  double radius_mm() const noexcept { return radius_mm_; }

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using MatrixX6 = Eigen::Matrix<double, Eigen::Dynamic, 6>;
  void add_marker(Eigen::Index m, double weight, MatrixX6& c, Matrix6& p) const noexcept;

  Eigen::MatrixXd rows_;             // K x 3M, as MarkerBasis has it
  Eigen::Matrix3Xd from_centre_mm_;  // 3 x M
  Eigen::Vector3d centre_mm_;
  double radius_mm_ = 0;
  Eigen::VectorXd usual_weight_, weight_;  // M
  MatrixX6 usual_c_, c_, c_whitened_;      // K x 6; the last C L^-T, with P = L L'
  Matrix6 usual_p_, p_;
  Eigen::LLT<Matrix6> factor_;
  Vector6 a_;
};

}  // namespace risorius
