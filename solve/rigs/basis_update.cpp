#include "solve/rigs/basis_update.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "capture/check.h"

namespace risorius {
namespace {

constexpr double kLeastEvidence = 1e-10;  // of the largest eigenvalue: directions with less say nothing

/// residual = matrix * parameters - target, over scalar parameter blocks.
class LinearCost final : public ceres::CostFunction {
 public:
  LinearCost(Eigen::MatrixXd matrix, Eigen::VectorXd target) : matrix_(std::move(matrix)), target_(std::move(target)) {
    set_num_residuals(static_cast<int>(matrix_.rows()));
    mutable_parameter_block_sizes()->assign(static_cast<std::size_t>(matrix_.cols()), 1);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, matrix_.rows());
    r = -target_;
    for (Eigen::Index i = 0; i < matrix_.cols(); ++i) r += *parameters[i] * matrix_.col(i);
    if (jacobians == nullptr) return true;
    for (Eigen::Index i = 0; i < matrix_.cols(); ++i) {
      if (jacobians[i] != nullptr) Eigen::Map<Eigen::VectorXd>(jacobians[i], matrix_.rows()) = matrix_.col(i);
    }
    return true;
  }

 private:
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd target_;
};

/// The data term of one marker as few rows: G = V S V', so rows sqrt(S) V' and targets S^-1/2 V' b.
struct MarkerRows {
  Eigen::MatrixXd matrix;   // rows x (K+1)
  Eigen::MatrixXd targets;  // rows x 3
};

MarkerRows rows_of(const BasisEvidence& evidence, std::size_t m, double noise_mm) {
  Eigen::MatrixXd gram = evidence.gram(m);
  gram.bottomRightCorner(gram.rows() - 1, gram.cols() - 1) += noise_mm * noise_mm * evidence.doubt(m);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const auto size = values.size();
  Eigen::Index first = 0;  // eigenvalues rise
  while (first < size && !(values[first] > kLeastEvidence * values[size - 1])) ++first;
  const Eigen::Index kept = size - first;
  const Eigen::VectorXd root = values.tail(kept).cwiseSqrt();
  const Eigen::MatrixXd basis = eigen.eigenvectors().rightCols(kept).transpose();
  return {(root / noise_mm).asDiagonal() * basis,
          (root.cwiseInverse() / noise_mm).asDiagonal() * basis * evidence.target(m)};
}

/// The inverse of the Cholesky factor of C_i: what makes the prior's residuals independent.
Eigen::MatrixXd whitening_of(const Rig& rig, const RigAu& au, const BasisPrior& prior) {
  const Eigen::Index markers = rig.neutral_mm.cols();
  const double peak_mm = au.displacement_mm.colwise().norm().maxCoeff();
  const Eigen::VectorXd deviation = (prior.share * reach_of(rig, au, prior.reach_mm)).array() + prior.floor * peak_mm;
  Eigen::MatrixXd covariance(markers, markers);
  for (Eigen::Index a = 0; a < markers; ++a) {
    for (Eigen::Index b = 0; b < markers; ++b) {
      const double distance = (rig.neutral_mm.col(a) - rig.neutral_mm.col(b)).norm() / prior.correlation_mm;
      covariance(a, b) =
          deviation[a] * deviation[b] *
          ((1 - prior.own_share) * std::exp(-0.5 * distance * distance) + (a == b ? prior.own_share : 0));
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  RISORIUS_CHECK(factor.info() == Eigen::Success);
  return factor.matrixL().solve(Eigen::MatrixXd::Identity(markers, markers));
}

/// One axis: unknowns (K+1) x M, changes against the start.
class AxisProblem {
 public:
  AxisProblem(Eigen::Index rows, Eigen::Index markers) : change_(Eigen::MatrixXd::Zero(rows, markers)) {}

  void add_marker(const MarkerRows& rows, const Eigen::VectorXd& start, Eigen::Index m, int axis,
                  const std::vector<char>& is_free) {
    std::vector<double*> blocks;
    for (Eigen::Index i = 0; i < change_.rows(); ++i) blocks.push_back(&change_(i, m));
    problem_.AddResidualBlock(new LinearCost(rows.matrix, rows.targets.col(axis) - rows.matrix * start), nullptr,
                              blocks);
    for (Eigen::Index i = 0; i < change_.rows(); ++i) {
      if (is_free[static_cast<std::size_t>(i)] == 0) problem_.SetParameterBlockConstant(&change_(i, m));
    }
  }

  /// `row` 0 is the neutral.
  void add_prior(const Eigen::MatrixXd& whitening, Eigen::Index row) {
    std::vector<double*> blocks;
    for (Eigen::Index m = 0; m < change_.cols(); ++m) blocks.push_back(&change_(row, m));
    problem_.AddResidualBlock(new LinearCost(whitening, Eigen::VectorXd::Zero(whitening.rows())), nullptr, blocks);
  }

  const Eigen::MatrixXd& solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::CGNR;
    options.preconditioner_type = ceres::JACOBI;
    options.max_num_iterations = 4;  // it is linear: one step, and what the conjugate gradients left of it
    options.max_linear_solver_iterations = 400;
    options.eta = 1e-6;
    options.initial_trust_region_radius = 1e14;
    options.function_tolerance = 1e-9;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    RISORIUS_CHECK(summary.IsSolutionUsable());
    return change_;
  }

 private:
  Eigen::MatrixXd change_;
  ceres::Problem problem_;
};

}  // namespace

Eigen::VectorXd reach_of(const Rig& rig, const RigAu& au, double reach_mm) {
  const Eigen::Index markers = rig.neutral_mm.cols();
  Eigen::VectorXd reach = Eigen::VectorXd::Zero(markers);
  for (Eigen::Index m = 0; m < markers; ++m) {
    for (Eigen::Index other = 0; other < markers; ++other) {
      const double distance = (rig.neutral_mm.col(m) - rig.neutral_mm.col(other)).norm() / reach_mm;
      reach[m] = std::max(reach[m], au.displacement_mm.col(other).norm() * std::exp(-0.5 * distance * distance));
    }
  }
  return reach;
}

BasisEvidence::BasisEvidence(std::size_t marker_count, std::size_t au_count) {
  const auto size = static_cast<Eigen::Index>(au_count) + 1;
  gram_.assign(marker_count, Eigen::MatrixXd::Zero(size, size));
  target_.assign(marker_count, Eigen::MatrixXd::Zero(size, 3));
  doubt_.assign(marker_count, Eigen::MatrixXd::Zero(size - 1, size - 1));
  row_.resize(size);
}

void BasisEvidence::add(const Eigen::VectorXd& x, const Eigen::MatrixXd& unit_covariance, const Eigen::Matrix3Xd& y_mm,
                        const Eigen::VectorXd& weight, double frame_weight) {
  row_ << 1, x;
  for (std::size_t m = 0; m < gram_.size(); ++m) {
    const double w = frame_weight * weight[static_cast<Eigen::Index>(m)];
    if (!(w > 0)) continue;
    gram_[m].noalias() += (w * row_) * row_.transpose();
    target_[m].noalias() += (w * row_) * y_mm.col(static_cast<Eigen::Index>(m)).transpose();
    doubt_[m] += w * unit_covariance;
  }
}

Rig update_basis(const Rig& start, const BasisEvidence& evidence, const BasisPrior& prior, double noise_mm,
                 const std::vector<char>& free) {
  const auto markers = static_cast<Eigen::Index>(start.marker_count());
  const auto rows = static_cast<Eigen::Index>(start.au_count()) + 1;
  const bool keeps_neutral = !(prior.neutral_mm > 0);
  std::vector<char> is_free{static_cast<char>(keeps_neutral ? 0 : 1)};  // rows: the neutral, then the AUs
  is_free.insert(is_free.end(), free.begin(), free.end());
  std::vector<MarkerRows> data;
  for (std::size_t m = 0; m < evidence.marker_count(); ++m) data.push_back(rows_of(evidence, m, noise_mm));
  std::vector<Eigen::MatrixXd> whitening;
  whitening.emplace_back(Eigen::MatrixXd::Identity(markers, markers) / (keeps_neutral ? 1 : prior.neutral_mm));
  for (const RigAu& au : start.aus) whitening.push_back(whitening_of(start, au, prior));

  Rig updated = start;
  for (int axis = 0; axis < 3; ++axis) {
    AxisProblem problem(rows, markers);
    for (Eigen::Index m = 0; m < markers; ++m) {
      Eigen::VectorXd fields = Eigen::VectorXd::Zero(rows);
      for (Eigen::Index i = 1; i < rows; ++i) {
        fields[i] = start.aus[static_cast<std::size_t>(i) - 1].displacement_mm(axis, m);
      }
      problem.add_marker(data[static_cast<std::size_t>(m)], fields, m, axis, is_free);
    }
    for (Eigen::Index i = 0; i < rows; ++i) {
      if (is_free[static_cast<std::size_t>(i)] != 0) problem.add_prior(whitening[static_cast<std::size_t>(i)], i);
    }
    const Eigen::MatrixXd& change = problem.solve();
    if (!keeps_neutral) updated.neutral_mm.row(axis) += change.row(0);
    for (Eigen::Index i = 1; i < rows; ++i) {
      updated.aus[static_cast<std::size_t>(i) - 1].displacement_mm.row(axis) += change.row(i);
    }
  }
  return updated;
}

void validate(const BasisPrior& p) {
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) throw std::invalid_argument(fmt::format("BasisPrior.{} = {}: must be {}", name, value, range));
  };
  require(p.share > 0 && p.share <= 10, "share", p.share, "above 0, at most 10");
  require(p.floor > 0 && p.floor <= 1, "floor", p.floor, "above 0, at most 1");
  require(p.reach_mm > 0 && p.reach_mm <= 1000, "reach_mm", p.reach_mm, "above 0, at most 1000");
  require(p.correlation_mm > 0 && p.correlation_mm <= 1000, "correlation_mm", p.correlation_mm,
          "above 0, at most 1000");
  require(p.own_share > 0 && p.own_share <= 1, "own_share", p.own_share, "above 0, at most 1");
  require(p.neutral_mm >= 0 && p.neutral_mm <= 100, "neutral_mm", p.neutral_mm, "0 to 100");
}

}  // namespace risorius
