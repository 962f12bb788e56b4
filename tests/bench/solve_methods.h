// The solvers that bench_solve compares, each warm-started and with the ridge of the stage's default.
#pragma once

#include <Eigen/Cholesky>
#include <ceres/ceres.h>
#include <vector>

#include "solve/bounded_qp.h"
#include "solve/rigs/marker_basis.h"
#include "synthetic_face.h"

namespace risorius::bench {

inline constexpr double kRidge = 1e-3;  // as the stage's default

struct Problem {
  Rig rig;
  Eigen::MatrixXd e;  // 3M x K
  std::vector<MarkerFrame> frames;
  std::vector<Eigen::VectorXd> y;  // 3M each, head frame
  double ridge_mm2 = 0;
};

inline Problem make_problem(int markers, int aus, int frames) {
  Problem p;
  p.rig = test::synthetic_rig(markers, aus);
  p.e.resize(3 * markers, aus);
  for (int i = 0; i < aus; ++i) p.e.col(i) = p.rig.aus[static_cast<std::size_t>(i)].displacement_mm.reshaped();
  p.ridge_mm2 = kRidge * MarkerBasis(p.rig).mean_diagonal_mm2();
  for (int f = 0; f < frames; ++f) {
    p.frames.push_back(
        test::marker_frame(p.rig, test::smooth_intensities(aus, f / 60.0), {}, static_cast<unsigned>(f)));
    test::add_noise(p.frames.back(), 0.2, static_cast<unsigned>(f));
    Eigen::VectorXd y(3 * markers);
    for (int m = 0; m < markers; ++m) {
      const Position& q = p.frames.back().position_mm[static_cast<std::size_t>(m)];
      y.segment<3>(3 * m) = Eigen::Vector3d(q.x, q.y, q.z) - p.rig.neutral_mm.col(m);
    }
    p.y.push_back(y);
  }
  return p;
}

/// The path of the stage: right-hand side, Gram matrix with penalties, exact QP with Ceres inside.
class LivePath {
 public:
  explicit LivePath(const Problem& p) : problem_(p), basis_(p.rig), qp_(static_cast<int>(p.e.cols())) {
    basis_.gram(Eigen::VectorXd::Ones(basis_.marker_count()), gram_);
    upper_.setConstant(p.e.cols(), 1.2);
    x.setZero(p.e.cols());
  }
  void solve(std::size_t frame) {
    basis_.project(problem_.y[frame], b_);
    h_ = gram_;
    solve_with_penalties();
  }
  /// Every 20th marker is missing, and every frame others: the Gram matrix is downdated each time.
  void solve_with_5_percent_missing(std::size_t frame) {
    y_ = problem_.y[frame];
    weight_.setOnes(basis_.marker_count());
    for (auto m = static_cast<Eigen::Index>(frame % 20); m < weight_.size(); m += 20) {
      weight_[m] = 0;
      y_.segment<3>(3 * m).setZero();
    }
    basis_.project(y_, b_);
    basis_.gram(weight_, h_);
    solve_with_penalties();
  }
  Eigen::VectorXd x;
  int free_sets = 0;

 private:
  void solve_with_penalties() {
    h_.diagonal().array() += problem_.ridge_mm2;
    free_sets += qp_.solve(h_, b_, upper_, x).free_set_solves;
  }
  const Problem& problem_;
  MarkerBasis basis_;
  BoundedQp qp_;
  Eigen::MatrixXd gram_ = Eigen::MatrixXd(basis_.au_count(), basis_.au_count()), h_ = gram_;
  Eigen::VectorXd b_, upper_, y_, weight_;
};

/// The textbook: primal active set on the Gram matrix, one Cholesky per free set, warm-started; nothing but Eigen.
class PlainGram {
 public:
  explicit PlainGram(const Problem& p) : problem_(p), gram_(p.e.transpose() * p.e) {
    gram_.diagonal().array() += p.ridge_mm2;
    x.setZero(p.e.cols());
    place_.assign(static_cast<std::size_t>(p.e.cols()), 0);
  }
  void solve(std::size_t frame) {
    b_.noalias() = problem_.e.transpose() * problem_.y[frame];
    for (;;) {
      minimise();
      int released = -1;
      double most = 1e-12;
      gradient_.noalias() = gram_ * x - b_;
      for (int i = 0; i < x.size(); ++i) {
        if (place_[i] == 0) continue;
        const double offence = place_[i] * gradient_[i] / gram_(i, i);
        if (offence > most) {
          most = offence;
          released = i;
        }
      }
      if (released < 0) return;
      place_[released] = 0;
    }
  }
  Eigen::VectorXd x;

 private:
  void minimise() {
    for (;;) {
      free_.clear();
      for (int i = 0; i < x.size(); ++i) {
        if (place_[i] == 0) free_.push_back(i);
      }
      if (free_.empty()) return;
      gradient_.noalias() = b_ - gram_ * x;
      h_free_ = gram_(free_, free_);
      step_ = gradient_(free_);
      llt_.compute(h_free_);
      llt_.solveInPlace(step_);
      double share = 1;
      int blocking = -1;
      for (std::size_t k = 0; k < free_.size(); ++k) {
        const double s = step_[static_cast<Eigen::Index>(k)], from = x[free_[k]];
        const double room = s < 0 ? -from / s : s > 0 ? (1.2 - from) / s : 1;
        if (room < share) {
          share = room;
          blocking = static_cast<int>(k);
        }
      }
      for (std::size_t k = 0; k < free_.size(); ++k) x[free_[k]] += share * step_[static_cast<Eigen::Index>(k)];
      if (blocking < 0) return;
      const bool upper = step_[blocking] > 0;
      x[free_[static_cast<std::size_t>(blocking)]] = upper ? 1.2 : 0;
      place_[free_[static_cast<std::size_t>(blocking)]] = upper ? 1 : -1;
    }
  }
  const Problem& problem_;
  Eigen::MatrixXd gram_, h_free_;
  Eigen::VectorXd b_, gradient_, step_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  std::vector<int> place_;  // -1 lower, 0 free, 1 upper
  std::vector<int> free_;
};

/// r = (E x - y, sqrt(ridge) x) with its exact Jacobian.
class FullResidual final : public ceres::CostFunction {
 public:
  explicit FullResidual(const Problem& p) : problem_(p) {
    set_num_residuals(static_cast<int>(p.e.rows() + p.e.cols()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(p.e.cols()));
    jacobian_.setZero(num_residuals(), p.e.cols());
    jacobian_.topRows(p.e.rows()) = p.e;
    jacobian_.bottomRows(p.e.cols()).diagonal().setConstant(std::sqrt(p.ridge_mm2));
  }
  void look_at(std::size_t frame) { frame_ = frame; }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r.noalias() = jacobian_ * Eigen::Map<const Eigen::VectorXd>(parameters[0], problem_.e.cols());
    r.head(problem_.e.rows()) -= problem_.y[frame_];
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(jacobians[0], jacobian_.rows(), jacobian_.cols()) =
          jacobian_;
    }
    return true;
  }

 private:
  const Problem& problem_;
  Eigen::MatrixXd jacobian_;
  std::size_t frame_ = 0;
};

class BoundedCeres {
 public:
  explicit BoundedCeres(const Problem& p) : cost_(new FullResidual(p)) {
    x.setZero(p.e.cols());
    problem_.AddResidualBlock(cost_, nullptr, x.data());
    for (int i = 0; i < x.size(); ++i) {
      problem_.SetParameterLowerBound(x.data(), i, 0);
      problem_.SetParameterUpperBound(x.data(), i, 1.2);
    }
    options_.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options_.logging_type = ceres::SILENT;
    options_.num_threads = 1;
  }
  void solve(std::size_t frame) {
    cost_->look_at(frame);
    ceres::Solver::Summary summary;
    ceres::Solve(options_, &problem_, &summary);
  }
  Eigen::VectorXd x;

 private:
  FullResidual* cost_;  // owned by problem_
  ceres::Problem problem_;
  ceres::Solver::Options options_;
};

/// No bounds while solving, clamped to them afterwards: fast, and not the optimum.
class UnconstrainedClamped {
 public:
  explicit UnconstrainedClamped(const Problem& p) : problem_(p), gram_(p.e.transpose() * p.e) {
    gram_.diagonal().array() += p.ridge_mm2;
    factor_.compute(gram_);
    x.setZero(p.e.cols());
  }
  void solve(std::size_t frame) {
    x.noalias() = problem_.e.transpose() * problem_.y[frame];
    factor_.solveInPlace(x);
    x = x.cwiseMax(0).cwiseMin(1.2);
  }
  Eigen::VectorXd x;

 private:
  const Problem& problem_;
  Eigen::MatrixXd gram_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace risorius::bench
