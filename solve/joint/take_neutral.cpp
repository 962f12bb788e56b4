#include "solve/joint/take_neutral.h"

#include <algorithm>

#include "solve/rigs/marker_basis.h"
#include "solve/rigs/rigid_part.h"

namespace risorius {
namespace {

constexpr double kAlike_s = 2;
constexpr double kLeast = 1e-12;

}  // namespace

double TakeNeutral::update(std::vector<JointFrame>& frames, const JointState& state, double variance_mm2,
                           double step_s) {
  const auto markers = static_cast<Eigen::Index>(rig_.marker_count());
  const MarkerBasis basis(rig_);
  const JointNormalMaker maker(rig_);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, markers);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(markers), fitted_mm(3 * markers);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const JointFrame& frame = frames[f];
    if (!frame.is_solved) continue;
    const auto column = static_cast<Eigen::Index>(f);
    const RigidTransform step = maker.moved({}, state.d.col(column));
    basis.deform(state.x.col(column), fitted_mm);
    for (Eigen::Index m = 0; m < markers; ++m) {
      if (!(frame.weight[m] > 0)) continue;
      const Eigen::Vector3d neutral = rig_.neutral_mm.col(m);
      const Eigen::Vector3d seen = step * Eigen::Vector3d(frame.y_mm.segment<3>(3 * m) + neutral);
      sum.col(m) += frame.weight[m] * (seen - neutral - fitted_mm.segment<3>(3 * m));
      weight[m] += frame.weight[m];
    }
  }
  const double prior =
      variance_mm2 / (deviation_mm_ * deviation_mm_) * (step_s > 0 ? std::max(1.0, kAlike_s / step_s) : 1);
  Eigen::Matrix3Xd shift_mm = rig_.neutral_mm - start_.neutral_mm;
  for (Eigen::Index m = 0; m < markers; ++m) {
    shift_mm.col(m) += (sum.col(m) - prior * shift_mm.col(m)) / std::max(weight[m] + prior, kLeast);
  }
  shift_mm -= rigid_part(start_.neutral_mm, shift_mm, start_.stabiliser_weight);
  const Eigen::Matrix3Xd change_mm = start_.neutral_mm + shift_mm - rig_.neutral_mm;
  rig_.neutral_mm += change_mm;
  for (JointFrame& frame : frames) {
    if (!frame.is_solved) continue;
    for (Eigen::Index m = 0; m < markers; ++m) {
      if (frame.weight[m] > 0) frame.y_mm.segment<3>(3 * m) -= change_mm.col(m);
    }
  }
  return change_mm.colwise().norm().maxCoeff();
}

}  // namespace risorius
