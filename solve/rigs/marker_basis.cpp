#include "solve/rigs/marker_basis.h"

namespace risorius {

MarkerBasis::MarkerBasis(const Rig& rig) {
  const auto markers = static_cast<Eigen::Index>(rig.marker_count());
  const auto aus = static_cast<Eigen::Index>(rig.au_count());
  rows_.resize(aus, 3 * markers);
  energy_share_.resize(aus, markers);
  for (Eigen::Index i = 0; i < aus; ++i) {
    const Eigen::Matrix3Xd& field = rig.aus[static_cast<std::size_t>(i)].displacement_mm;
    const double energy = field.squaredNorm();
    mean_diagonal_mm2_ += energy / static_cast<double>(aus);
    for (Eigen::Index m = 0; m < markers; ++m) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) rows_(i, 3 * m + axis) = field(axis, m);
      energy_share_(i, m) = field.col(m).squaredNorm() / energy;
    }
  }
  usual_gram_.resize(aus, aus);
  usual_weight_.resize(markers);
  use_weights(Eigen::VectorXd::Ones(markers));
}

void MarkerBasis::use_weights(const Eigen::VectorXd& usual) noexcept {
  usual_weight_ = usual;
  usual_gram_.setZero();
  for (Eigen::Index m = 0; m < marker_count(); ++m) add_marker(m, usual[m], usual_gram_);
}

void MarkerBasis::add_marker(Eigen::Index m, double weight, Eigen::MatrixXd& h) const noexcept {
  if (weight == 0) return;
  const auto x = rows_.col(3 * m), y = rows_.col(3 * m + 1), z = rows_.col(3 * m + 2);
  for (Eigen::Index j = 0; j < h.cols(); ++j) {
    const Eigen::Index rest = h.rows() - j;
    h.col(j).tail(rest) +=
        (weight * x[j]) * x.tail(rest) + (weight * y[j]) * y.tail(rest) + (weight * z[j]) * z.tail(rest);
  }
}

void MarkerBasis::gram(const Eigen::VectorXd& weight, Eigen::MatrixXd& h) const noexcept {
  Eigen::Index differing = 0;
  for (Eigen::Index m = 0; m < marker_count(); ++m) differing += weight[m] != usual_weight_[m];
  if (2 * differing <= marker_count()) {
    h = usual_gram_;
    for (Eigen::Index m = 0; m < marker_count(); ++m) add_marker(m, weight[m] - usual_weight_[m], h);
  } else {
    h.setZero();
    for (Eigen::Index m = 0; m < marker_count(); ++m) add_marker(m, weight[m], h);
  }
  for (Eigen::Index j = 1; j < h.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) h(i, j) = h(j, i);
  }
}

void MarkerBasis::project(const Eigen::VectorXd& v_mm, Eigen::VectorXd& b) const noexcept {
  b.noalias() = rows_ * v_mm;
}

void MarkerBasis::deform(const Eigen::VectorXd& x, Eigen::VectorXd& displacement_mm) const noexcept {
  displacement_mm.noalias() = rows_.transpose() * x;
}

void MarkerBasis::visible_share(const Eigen::VectorXd& weight, Eigen::VectorXd& share) const noexcept {
  share.noalias() = energy_share_ * weight;
}

}  // namespace risorius
