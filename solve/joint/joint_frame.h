// What one frame of a take says about its intensities x (K) and a small step d of its head pose (6), as the normal
// equations of solve/README.md, eq. 4, without the terms that join it to its neighbours:
//     1/2 (d, x)' H (d, x) - b' (d, x)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/rigid_alignment.h"
#include "solve/pose_coupling.h"
#include "solve/rigs/marker_basis.h"

namespace risorius {

/// Of a frame that the causal solve looked at.
struct JointFrame {
  std::int64_t capture_time_ns = 0;
  bool is_solved = false;          ///< false: the markers say nothing, the neighbours everything
  RigidTransform head_from_world;  ///< about which the pose is linear
  Eigen::VectorXd y_mm;            ///< 3M: seen displacements in the head frame
  Eigen::VectorXd weight;          ///< M: robust, times the stabilisers' pull
  std::vector<char> observed;      ///< K
  std::vector<char> measured;      ///< M
};

struct JointPenalties {
  double ridge_mm2 = 0, l1_mm2 = 0;
};

struct JointNormal {
  Eigen::MatrixXd h;  ///< (6 + K) x (6 + K)
  Eigen::VectorXd b;  ///< 6 + K
};

class JointNormalMaker {
 public:
  explicit JointNormalMaker(const Rig& rig) : basis_(rig), coupling_(rig) {}
  JointNormal make(const JointFrame& frame, const JointPenalties& penalties);
  double mean_diagonal_mm2() const noexcept { return basis_.mean_diagonal_mm2(); }
  /// The pose after the step.
  RigidTransform moved(const RigidTransform& head_from_world, const Eigen::Matrix<double, 6, 1>& step) const;

 private:
  MarkerBasis basis_;
  PoseCoupling coupling_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd weighted_y_mm_, b_;
};

}  // namespace risorius
