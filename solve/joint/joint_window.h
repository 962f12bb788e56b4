// A stretch of a take as one problem: the intensities and head steps of all its frames, with the frames outside held.
// Ceres solves it on the free set (sparse Cholesky, one step: the problem is quadratic) inside a loop that exchanges
// the intensities that offend against optimality, as solve/bounded_qp.h does for one frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "solve/joint/joint_frame.h"

namespace risorius {

enum class JointPlace : std::uint8_t { kLower, kFree, kUpper };

/// All frames of a take: columns are frames.
struct JointState {
  Eigen::MatrixXd x;              ///< K x T
  Eigen::MatrixXd d;              ///< 6 x T
  std::vector<JointPlace> place;  ///< T x K
};

/// What joins frames: 1/2 sum_f sum_i w_if (x_i,f-1 - 2 x_if + x_i,f+1)^2; a weight of 0 where they are not neighbours.
struct JointSmoothness {
  Eigen::MatrixXd weight_mm2;  ///< K x T, of the frame in the middle; first and last column 0
};

class JointWindow {
 public:
  /// Frames first to last, both included. Keeps references.
  JointWindow(std::vector<JointNormal> normals, Eigen::Index first, const JointSmoothness& smoothness,
              const Eigen::VectorXd& upper);

  /// Solves from `state`, whose other frames are held, and leaves it as it is. At most `rounds` exchanges.
  void solve(const JointState& state, int rounds);

  Eigen::Index first() const noexcept { return first_; }
  Eigen::Index count() const noexcept { return static_cast<Eigen::Index>(normals_.size()); }
  /// Of the window's frames, in order.
  const JointState& solution() const noexcept { return local_; }

  /// || x - clip(x - D^-1 g, 0, upper) ||_inf of frame `first + f` of the whole problem at `state`.
  double kkt_residual(const JointState& state, Eigen::Index f) const;

 private:
  void minimise_on_free_set(const JointState& state);
  enum class Exchange { kAll, kWorst };
  int exchange_violators(const JointState& state, Exchange exchange);
  Eigen::VectorXd value(const JointState& state, Eigen::Index frame) const;
  void gradient(const JointState& state, bool own, Eigen::Index f, Eigen::VectorXd& g, Eigen::VectorXd& diagonal) const;

  std::vector<JointNormal> normals_;
  std::vector<Eigen::MatrixXd> root_;        // R with R'R = H, upper triangular
  std::vector<Eigen::VectorXd> whitened_b_;  // R'^-1 b
  Eigen::Index first_;
  const JointSmoothness& smoothness_;
  const Eigen::VectorXd& upper_;
  JointState local_;
};

}  // namespace risorius
