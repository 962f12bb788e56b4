#include "solve/joint/joint_frame.h"

namespace risorius {
namespace {

/// Where the markers say nothing the matrix must still be positive definite; beside millimetres squared this is
/// nothing.
constexpr double kLeast = 1e-6;

}  // namespace

JointNormal JointNormalMaker::make(const JointFrame& frame, const JointPenalties& penalties) {
  const Eigen::Index k = basis_.au_count();
  JointNormal normal{Eigen::MatrixXd::Zero(6 + k, 6 + k), Eigen::VectorXd::Zero(6 + k)};
  if (!frame.is_solved) {
    normal.h.diagonal().setConstant(kLeast);
    return normal;
  }
  gram_.resize(k, k);
  b_.resize(k);
  basis_.gram(frame.weight, gram_);
  weighted_y_mm_ = frame.y_mm;
  for (Eigen::Index m = 0; m < frame.weight.size(); ++m) weighted_y_mm_.segment<3>(3 * m) *= frame.weight[m];
  basis_.project(weighted_y_mm_, b_);
  coupling_.prepare(frame.weight);
  coupling_.project(weighted_y_mm_);
  normal.h.topLeftCorner<6, 6>() = coupling_.p();
  normal.h.bottomLeftCorner(k, 6) = coupling_.c();
  normal.h.topRightCorner(6, k) = coupling_.c().transpose();
  normal.h.bottomRightCorner(k, k) = gram_;
  normal.b.head<6>() = coupling_.a();
  normal.b.tail(k) = b_;
  normal.h.diagonal().array() += kLeast;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (!frame.observed[static_cast<std::size_t>(i)]) continue;  // its neighbours in time bridge it
    normal.h(6 + i, 6 + i) += penalties.ridge_mm2;
    normal.b[6 + i] -= penalties.l1_mm2;
  }
  return normal;
}

RigidTransform JointNormalMaker::moved(const RigidTransform& head_from_world,
                                       const Eigen::Matrix<double, 6, 1>& step) const {
  RigidTransform after = head_from_world;
  coupling_.move_head_by(step, after);
  return after;
}

}  // namespace risorius
