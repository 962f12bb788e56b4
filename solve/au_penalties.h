// What the solve asks of intensities beside the markers (solve/README.md, eq. 2): ridge, L1, equal sides, and to stay
// near the last frame. All are relative to the mean diagonal of the rig's Gram matrix, so that they mean the same for
// 16 markers and for 256. Allocates only when constructed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "solve/au_solver_options.h"
#include "solve/rigs/rig.h"

namespace risorius {

class AuPenalties {
 public:
  /// `unit_mm2`: the mean diagonal.
  AuPenalties(const Rig& rig, const AuSolverOptions& options, double unit_mm2);

  /// Of the frame to come: `follows[i]` says whether AU i is drawn to `previous` (K), `step_s` since then; 0 or less:
  /// none is. True if the quadratic part is another than the last frame's.
  bool begin_frame(std::span<const char> follows, const Eigen::VectorXd& previous, double step_s) noexcept;

  /// H += the quadratic part, K x K; b += the linear part.
  void add_to_hessian(Eigen::MatrixXd& h) const noexcept;
  void add_to_gradient(Eigen::VectorXd& b) const noexcept;

 private:
  AuSolverOptions options_;
  double unit_mm2_;
  std::vector<std::pair<int, int>> left_right_pairs_;
  Eigen::VectorXd temporal_mm2_, previous_;  // K
};

}  // namespace risorius
