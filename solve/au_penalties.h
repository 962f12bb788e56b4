// What the solve asks of intensities beside the markers (solve/README.md, eq. 2): ridge, L1, equal sides, and to stay
// near the last frame, the less the faster an AU moves. Allocates only when constructed.
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

  /// Of the frame to come: `follows[i]` says whether AU i is drawn to `previous` (K), `step_s` since then; 0: none is,
  /// and no AU moves. Frames come in order, for the speeds. True if the quadratic part is another than before.
  bool begin_frame(std::span<const char> follows, const Eigen::VectorXd& previous, double step_s) noexcept;
  /// Intensities of the last frame.
  const Eigen::VectorXd& previous() const noexcept { return previous_; }
  /// The variance of the residuals, mm^2 per axis, which scales L1.
  void expect_residuals(double variance_mm2) noexcept { l1_mm2_ = options_.l1 * variance_mm2; }

  /// H += the quadratic part, K x K; b += the linear part.
  void add_to_hessian(Eigen::MatrixXd& h) const noexcept;
  void add_to_gradient(Eigen::VectorXd& b) const noexcept;

 private:
  AuSolverOptions options_;
  double unit_mm2_;
  std::vector<std::pair<int, int>> left_right_pairs_;
  double l1_mm2_ = 0, last_step_s_ = 0;
  Eigen::VectorXd temporal_mm2_, previous_, speed_per_s_;  // K
};

}  // namespace risorius
