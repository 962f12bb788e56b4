#include "solve/pose_coupling.h"

#include <cmath>

namespace risorius {

PoseCoupling::PoseCoupling(const Rig& rig) {
  const auto markers = static_cast<Eigen::Index>(rig.marker_count());
  const auto aus = static_cast<Eigen::Index>(rig.au_count());
  rows_.resize(aus, 3 * markers);
  for (Eigen::Index i = 0; i < aus; ++i) {
    rows_.row(i) = rig.aus[static_cast<std::size_t>(i)].displacement_mm.reshaped().transpose();
  }
  from_centre_mm_.resize(3, markers);
  usual_c_.resize(aus, 6);
  c_.resize(aus, 6);
  c_whitened_.resize(aus, 6);
  usual_weight_ = weight_ = Eigen::VectorXd::Ones(markers);
  use_neutral(rig);
}

void PoseCoupling::use_neutral(const Rig& rig) noexcept {
  centre_mm_ = rig.neutral_mm.rowwise().mean();
  from_centre_mm_ = rig.neutral_mm.colwise() - centre_mm_;
  radius_mm_ = std::sqrt(from_centre_mm_.colwise().squaredNorm().mean());
  use_weights(usual_weight_);
}

void PoseCoupling::use_weights(const Eigen::VectorXd& usual) noexcept {
  usual_weight_ = usual;
  usual_c_.setZero();
  usual_p_.setZero();
  for (Eigen::Index m = 0; m < usual.size(); ++m) add_marker(m, usual[m], usual_c_, usual_p_);
  weight_.setConstant(-1);  // of no frame
}

void PoseCoupling::add_marker(Eigen::Index m, double weight, MatrixX6& c, Matrix6& p) const noexcept {
  if (weight == 0) return;
  const Eigen::Vector3d q = from_centre_mm_.col(m);
  Eigen::Matrix<double, 3, 6> j;
  j << 0, -q.z(), q.y(), -1, 0, 0,  //
      q.z(), 0, -q.x(), 0, -1, 0,   //
      -q.y(), q.x(), 0, 0, 0, -1;
  c.noalias() += (weight * rows_.middleCols<3>(3 * m)).lazyProduct(j);
  p.noalias() += weight * j.transpose().lazyProduct(j);
}

bool PoseCoupling::prepare(const Eigen::VectorXd& weight) noexcept {
  if (weight == weight_) return factor_.info() == Eigen::Success;
  weight_ = weight;
  Eigen::Index differing = 0;
  for (Eigen::Index m = 0; m < weight.size(); ++m) differing += weight[m] != usual_weight_[m];
  const bool from_usual = 2 * differing <= weight.size();
  if (from_usual) {
    c_ = usual_c_;
    p_ = usual_p_;
  } else {
    c_.setZero();
    p_.setZero();
  }
  for (Eigen::Index m = 0; m < weight.size(); ++m) {
    const double change = from_usual ? weight[m] - usual_weight_[m] : weight[m];
    add_marker(m, change, c_, p_);
  }
  factor_.compute(p_);
  if (factor_.info() != Eigen::Success) return false;
  c_whitened_ = c_;
  factor_.matrixL().transpose().solveInPlace<Eigen::OnTheRight>(c_whitened_);
  return true;
}

void PoseCoupling::project(const Eigen::VectorXd& weighted_y_mm) noexcept {
  a_.setZero();
  for (Eigen::Index m = 0; m < from_centre_mm_.cols(); ++m) {
    const Eigen::Vector3d y = weighted_y_mm.segment<3>(3 * m);
    // [q]_x' y = -q x y
    a_.head<3>() -= from_centre_mm_.col(m).cross(y);
    a_.tail<3>() -= y;
  }
}

void PoseCoupling::reduce_hessian(Eigen::MatrixXd& h) const noexcept {
  // Six columns in one pass: their sum is bound by loads and stores of h. Symmetric, so one half is enough.
  const auto& c = c_whitened_;
  for (Eigen::Index j = 0; j < h.cols(); ++j) {
    const Eigen::Index rest = h.rows() - j;
    h.col(j).tail(rest) -= c(j, 0) * c.col(0).tail(rest) + c(j, 1) * c.col(1).tail(rest) +
                           c(j, 2) * c.col(2).tail(rest) + c(j, 3) * c.col(3).tail(rest) +
                           c(j, 4) * c.col(4).tail(rest) + c(j, 5) * c.col(5).tail(rest);
  }
  for (Eigen::Index j = 1; j < h.cols(); ++j) h.col(j).head(j) = h.row(j).head(j).transpose();
}

void PoseCoupling::reduce_gradient(Eigen::VectorXd& b) const noexcept {
  Vector6 whitened = a_;
  factor_.matrixL().solveInPlace(whitened);
  for (Eigen::Index d = 0; d < 6; ++d) b -= whitened[d] * c_whitened_.col(d);
}

double PoseCoupling::move_head(const Eigen::VectorXd& x, RigidTransform& head_from_world) const noexcept {
  Vector6 step = a_;
  for (Eigen::Index d = 0; d < 6; ++d) step[d] -= c_.col(d).dot(x);
  factor_.solveInPlace(step);
  return move_head_by(step, head_from_world);
}

double PoseCoupling::move_head_by(const Vector6& step, RigidTransform& head_from_world) const noexcept {
  const Eigen::Vector3d omega = step.head<3>(), tau = step.tail<3>();
  const double angle = omega.norm();
  const Eigen::Quaterniond turn =
      angle > 1e-12 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, omega / angle)) : Eigen::Quaterniond::Identity();
  head_from_world.translation = turn * (head_from_world.translation - centre_mm_) + centre_mm_ + tau;
  head_from_world.rotation = (turn * head_from_world.rotation).normalized();
  return angle * radius_mm_ + tau.norm();
}

}  // namespace risorius
