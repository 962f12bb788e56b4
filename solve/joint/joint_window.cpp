#include "solve/joint/joint_window.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <ceres/ceres.h>
#include <cmath>

namespace risorius {
namespace {

constexpr double kTolerance = 1e-10;        // of x and D^-1 g
constexpr int kPatience = 4;                // exchanges that may fail to lower the number of violators
constexpr Eigen::Index kNeighbourhood = 6;  // frames to either side

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<int> free_of(const JointState& state, Eigen::Index f, Eigen::Index k) {
  std::vector<int> free;
  for (Eigen::Index i = 0; i < k; ++i) {
    if (state.place[static_cast<std::size_t>(f * k + i)] == JointPlace::kFree) free.push_back(static_cast<int>(i));
  }
  return free;
}

/// r = R_d d + R_x x_free - z.
class FrameCost final : public ceres::CostFunction {
 public:
  FrameCost(const Eigen::MatrixXd& root, const Eigen::VectorXd& whitened_b, const Eigen::VectorXd& fixed,
            const std::vector<int>& free)
      : of_d_(root.leftCols(6)), of_x_(root.rows(), static_cast<Eigen::Index>(free.size())) {
    z_ = whitened_b - root.rightCols(fixed.size()) * fixed;
    for (std::size_t j = 0; j < free.size(); ++j) of_x_.col(static_cast<Eigen::Index>(j)) = root.col(6 + free[j]);
    set_num_residuals(static_cast<int>(root.rows()));
    mutable_parameter_block_sizes()->push_back(6);
    if (!free.empty()) mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    r = -z_;
    r.noalias() += of_d_ * Eigen::Map<const Eigen::VectorXd>(parameters[0], 6);
    if (of_x_.cols() > 0) r.noalias() += of_x_ * Eigen::Map<const Eigen::VectorXd>(parameters[1], of_x_.cols());
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<RowMajor>(jacobians[0], of_d_.rows(), 6) = of_d_;
    if (of_x_.cols() > 0 && jacobians[1] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[1], of_x_.rows(), of_x_.cols()) = of_x_;
    }
    return true;
  }

 private:
  Eigen::MatrixXd of_d_, of_x_;
  Eigen::VectorXd z_;
};

/// r_i = s_i (x_i,f-1 - 2 x_if + x_i,f+1) for the rows of which something is free.
class SmoothCost final : public ceres::CostFunction {
 public:
  struct Row {
    double root_weight;
    std::array<int, 3> column;  // in its frame's block, or -1
    double fixed;               // the part that is not free
  };
  SmoothCost(std::vector<Row> rows, const std::array<int, 3>& sizes) : rows_(std::move(rows)), sizes_(sizes) {
    set_num_residuals(static_cast<int>(rows_.size()));
    for (const int size : sizes) {
      if (size > 0) mutable_parameter_block_sizes()->push_back(size);
    }
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (std::size_t i = 0; i < rows_.size(); ++i) residuals[i] = rows_[i].root_weight * rows_[i].fixed;
    int block = 0;
    for (std::size_t frame = 0; frame < 3; ++frame) {
      if (sizes_[frame] == 0) continue;
      double* jacobian = jacobians != nullptr ? jacobians[block] : nullptr;
      if (jacobian != nullptr) std::fill_n(jacobian, rows_.size() * static_cast<std::size_t>(sizes_[frame]), 0.0);
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        const int column = rows_[i].column[frame];
        if (column < 0) continue;
        const double slope = kStencil[frame] * rows_[i].root_weight;
        residuals[i] += slope * parameters[block][column];
        if (jacobian != nullptr)
          jacobian[i * static_cast<std::size_t>(sizes_[frame]) + static_cast<std::size_t>(column)] = slope;
      }
      ++block;
    }
    return true;
  }
  static constexpr std::array<double, 3> kStencil{1, -2, 1};

 private:
  std::vector<Row> rows_;
  std::array<int, 3> sizes_;
};

ceres::Solver::Options one_newton_step() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 1;
  options.initial_trust_region_radius = options.max_trust_region_radius = 1e30;
  options.jacobi_scaling = true;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  return options;
}

}  // namespace

JointWindow::JointWindow(std::vector<JointNormal> normals, Eigen::Index first, const JointSmoothness& smoothness,
                         const Eigen::VectorXd& upper)
    : normals_(std::move(normals)), first_(first), smoothness_(smoothness), upper_(upper) {
  for (const JointNormal& normal : normals_) {
    const Eigen::LLT<Eigen::MatrixXd> factor(normal.h);
    root_.emplace_back(factor.matrixU());
    whitened_b_.emplace_back(factor.matrixL().solve(normal.b));
  }
}

void JointWindow::solve(const JointState& state, int rounds) {
  const Eigen::Index k = upper_.size();
  local_.x = state.x.middleCols(first_, count());
  local_.d = state.d.middleCols(first_, count());
  local_.place.assign(state.place.begin() + first_ * k, state.place.begin() + (first_ + count()) * k);
  int fewest = static_cast<int>(local_.place.size()) + 1, patience = kPatience;
  for (int round = 0; round < rounds; ++round) {
    minimise_on_free_set(state);
    const int violators = exchange_violators(state, patience > 0 ? Exchange::kAll : Exchange::kWorst);
    if (violators == 0) break;
    if (violators < fewest) {
      fewest = violators;
      patience = kPatience;
    } else {
      --patience;
    }
  }
  // Where the exchange did not settle, the certificate will say by how much.
  for (Eigen::Index f = 0; f < count(); ++f) local_.x.col(f) = local_.x.col(f).cwiseMax(0).cwiseMin(upper_);
}

/// Intensities of frame `frame` of the take: the window's own, or those held outside.
Eigen::VectorXd JointWindow::value(const JointState& state, Eigen::Index frame) const {
  return frame >= first_ && frame < first_ + count() ? local_.x.col(frame - first_) : state.x.col(frame);
}

void JointWindow::minimise_on_free_set(const JointState& state) {
  const Eigen::Index k = upper_.size();
  std::vector<std::vector<int>> free;
  std::vector<Eigen::VectorXd> block;
  Eigen::MatrixXd fixed = local_.x;
  for (Eigen::Index f = 0; f < count(); ++f) {
    free.push_back(free_of(local_, f, k));
    block.emplace_back(static_cast<Eigen::Index>(free.back().size()));
    for (Eigen::Index i = 0; i < k; ++i) {
      const JointPlace place = local_.place[static_cast<std::size_t>(f * k + i)];
      fixed(i, f) = place == JointPlace::kUpper ? upper_[i] : 0;
    }
    for (std::size_t j = 0; j < free.back().size(); ++j)
      block.back()[static_cast<Eigen::Index>(j)] = local_.x(free.back()[j], f);
  }
  ceres::Problem problem;
  for (Eigen::Index f = 0; f < count(); ++f) {
    const auto at = static_cast<std::size_t>(f);
    auto* cost = new FrameCost(root_[at], whitened_b_[at], fixed.col(f), free[at]);
    std::vector<double*> parameters{local_.d.col(f).data()};
    if (!free[at].empty()) parameters.push_back(block[at].data());
    problem.AddResidualBlock(cost, nullptr, parameters);
  }
  // Smoothness about every frame that the window touches, also the two about its outer neighbours.
  for (Eigen::Index middle = std::max<Eigen::Index>(1, first_ - 1);
       middle <= std::min(first_ + count(), state.x.cols() - 2); ++middle) {
    std::array<int, 3> sizes{};
    std::vector<double*> parameters;
    std::array<std::vector<int>, 3> column;
    for (std::size_t n = 0; n < 3; ++n) {
      const Eigen::Index f = middle - 1 + static_cast<Eigen::Index>(n) - first_;
      column[n].assign(static_cast<std::size_t>(k), -1);
      if (f < 0 || f >= count()) continue;
      const auto& own = free[static_cast<std::size_t>(f)];
      for (std::size_t j = 0; j < own.size(); ++j) column[n][static_cast<std::size_t>(own[j])] = static_cast<int>(j);
      sizes[n] = static_cast<int>(own.size());
      if (!own.empty()) parameters.push_back(block[static_cast<std::size_t>(f)].data());
    }
    std::vector<SmoothCost::Row> rows;
    for (Eigen::Index i = 0; i < k; ++i) {
      const double weight = smoothness_.weight_mm2(i, middle);
      SmoothCost::Row row{std::sqrt(weight), {}, 0};
      bool is_free = false;
      for (std::size_t n = 0; n < 3; ++n) {
        row.column[n] = column[n][static_cast<std::size_t>(i)];
        const Eigen::Index f = middle - 1 + static_cast<Eigen::Index>(n);
        const bool is_own = f >= first_ && f < first_ + count();
        if (row.column[n] >= 0) {
          is_free = true;
        } else {
          row.fixed += SmoothCost::kStencil[n] * (is_own ? fixed(i, f - first_) : state.x(i, f));
        }
      }
      if (is_free && weight > 0) rows.push_back(row);
    }
    if (!rows.empty()) problem.AddResidualBlock(new SmoothCost(std::move(rows), sizes), nullptr, parameters);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(one_newton_step(), &problem, &summary);
  local_.x = fixed;
  for (Eigen::Index f = 0; f < count(); ++f) {
    const auto at = static_cast<std::size_t>(f);
    for (std::size_t j = 0; j < free[at].size(); ++j)
      local_.x(free[at][j], f) = block[at][static_cast<Eigen::Index>(j)];
  }
}

/// The gradient over x of frame `f` of the window, and the Hessian's diagonal. `own`: at the window's solution, else at
/// the state of the take.
void JointWindow::gradient(const JointState& state, bool own, Eigen::Index f, Eigen::VectorXd& g,
                           Eigen::VectorXd& diagonal) const {
  const Eigen::Index k = upper_.size(), frame = first_ + f;
  const JointNormal& normal = normals_[static_cast<std::size_t>(f)];
  const auto x_at = [&](Eigen::Index at) -> Eigen::VectorXd {
    return own ? value(state, at) : Eigen::VectorXd(state.x.col(at));
  };
  Eigen::VectorXd dx(6 + k);
  dx.head<6>() = own ? local_.d.col(f) : state.d.col(frame);
  dx.tail(k) = x_at(frame);
  g = normal.h.bottomRows(k) * dx - normal.b.tail(k);
  diagonal = normal.h.diagonal().tail(k);
  for (Eigen::Index middle = std::max<Eigen::Index>(1, frame - 1); middle <= std::min(frame + 1, state.x.cols() - 2);
       ++middle) {
    const double slope = SmoothCost::kStencil[static_cast<std::size_t>(frame - middle + 1)];
    const Eigen::VectorXd bend = x_at(middle - 1) - 2 * x_at(middle) + x_at(middle + 1);
    g.array() += slope * smoothness_.weight_mm2.col(middle).array() * bend.array();
    diagonal += slope * slope * smoothness_.weight_mm2.col(middle);
  }
}

/// Moves intensities that offend to where they strive: all, or, where that goes in circles, of each neighbourhood in
/// time only the worst. Returns how many offend.
int JointWindow::exchange_violators(const JointState& state, Exchange exchange) {
  const Eigen::Index k = upper_.size();
  int violators = 0;
  std::vector<double> worst(static_cast<std::size_t>(count()), 0);
  Eigen::MatrixXd offence(k, count());
  Eigen::VectorXd g, diagonal;
  for (Eigen::Index f = 0; f < count(); ++f) {
    gradient(state, true, f, g, diagonal);
    for (Eigen::Index i = 0; i < k; ++i) {
      const JointPlace place = local_.place[static_cast<std::size_t>(f * k + i)];
      const double x = local_.x(i, f), downhill = -g[i] / diagonal[i];
      const double by = place == JointPlace::kFree    ? std::max(-x, x - upper_[i])
                        : place == JointPlace::kLower ? downhill
                                                      : -downhill;
      offence(i, f) = by > kTolerance ? by : 0;
      violators += by > kTolerance;
    }
    worst[static_cast<std::size_t>(f)] = offence.col(f).maxCoeff();
  }
  for (Eigen::Index f = 0; f < count(); ++f) {
    double limit = 0;
    if (exchange == Exchange::kWorst) {
      const auto begin = worst.begin() + std::max<Eigen::Index>(0, f - kNeighbourhood);
      limit = *std::max_element(begin, worst.begin() + std::min(count(), f + kNeighbourhood + 1));
    }
    for (Eigen::Index i = 0; i < k; ++i) {
      if (!(offence(i, f) > 0) || offence(i, f) < limit) continue;
      JointPlace& place = local_.place[static_cast<std::size_t>(f * k + i)];
      place = place != JointPlace::kFree ? JointPlace::kFree
              : local_.x(i, f) < 0       ? JointPlace::kLower
                                         : JointPlace::kUpper;
    }
  }
  return violators;
}

double JointWindow::kkt_residual(const JointState& state, Eigen::Index f) const {
  Eigen::VectorXd g, diagonal;
  gradient(state, false, f, g, diagonal);
  const Eigen::VectorXd x = state.x.col(first_ + f);
  const Eigen::VectorXd projected = (x - g.cwiseQuotient(diagonal)).cwiseMax(0).cwiseMin(upper_);
  return (x - projected).lpNorm<Eigen::Infinity>();
}

}  // namespace risorius
