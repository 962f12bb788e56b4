#include "bench/component_ceiling.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "replay/performer/random.h"

namespace risorius::bench {
namespace {

constexpr int kDraws = 20;
constexpr std::size_t kHidden = 8;
constexpr std::uint64_t kSeed = 7;

/// Displacements (3M) of the frames in which every marker was measured, one column each.
Eigen::MatrixXd displacements_of(const Rig& rig, const TakeFrames& take) {
  std::vector<Eigen::VectorXd> columns;
  explain_take(rig, take, {}, [&](const ExplainedFrame& frame) {
    if (frame.measured.minCoeff() > 0) columns.emplace_back(frame.displacement_mm.reshaped());
  });
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(rig.marker_count()), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t t = 0; t < columns.size(); ++t) result.col(static_cast<Eigen::Index>(t)) = columns[t];
  return result;
}

using Components = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

LeftOutEnergy foretell(const Components& eigen, const Eigen::VectorXd& mean, const Eigen::MatrixXd& asked,
                       const std::vector<std::vector<std::size_t>>& hidden_groups, Eigen::Index count, double noise) {
  const Eigen::VectorXd variance = eigen.eigenvalues().tail(count).cwiseMax(1e-9);
  const Eigen::MatrixXd basis = eigen.eigenvectors().rightCols(count);
  LeftOutEnergy energy;
  for (const std::vector<std::size_t>& group : hidden_groups) {
    Eigen::VectorXd visible = Eigen::VectorXd::Ones(mean.size());
    for (const std::size_t m : group) visible.segment<3>(3 * static_cast<Eigen::Index>(m)).setZero();
    const Eigen::MatrixXd shown = visible.asDiagonal() * basis;
    Eigen::MatrixXd normal = shown.transpose() * shown;
    normal.diagonal() += noise * variance.cwiseInverse();
    const Eigen::MatrixXd scores = normal.ldlt().solve(shown.transpose() * (asked.colwise() - mean));
    const Eigen::MatrixXd foretold = (basis * scores).colwise() + mean;
    for (const std::size_t m : group) {
      const auto rows = 3 * static_cast<Eigen::Index>(m);
      energy.moved_mm2 += asked.middleRows<3>(rows).squaredNorm();
      energy.left_mm2 += (asked.middleRows<3>(rows) - foretold.middleRows<3>(rows)).squaredNorm();
      energy.samples += static_cast<double>(asked.cols());
    }
  }
  return energy;
}

}  // namespace

std::vector<std::vector<std::size_t>> hidden_draws(const Rig& rig) {
  std::vector<std::vector<std::size_t>> draws;
  Random random(kSeed, 1);
  std::vector<std::size_t> order;
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    if (rig.stabiliser_weight[static_cast<Eigen::Index>(m)] == 0) order.push_back(m);
  }
  if (order.size() < 2 * kHidden) return draws;
  std::ranges::stable_sort(order, {}, [&](std::size_t m) { return rig.neutral_mm(1, static_cast<Eigen::Index>(m)); });
  for (int d = 0; d < kDraws; ++d) {
    std::vector<std::size_t> hidden;
    while (hidden.size() < kHidden) {
      const std::size_t quarter = hidden.size() / 2;
      const std::size_t begin = quarter * order.size() / 4, end = (quarter + 1) * order.size() / 4;
      const std::size_t m = order[begin + random.index(end - begin)];
      if (std::ranges::find(hidden, m) == hidden.end()) hidden.push_back(m);
    }
    draws.push_back(std::move(hidden));
  }
  return draws;
}

LeftOutEnergy component_ceiling(const Rig& rig, const TakeFrames& learned, const TakeFrames& scored,
                                const std::vector<std::vector<std::size_t>>& hidden_groups, std::size_t components) {
  const Eigen::MatrixXd seen = displacements_of(rig, learned), asked = displacements_of(rig, scored);
  if (seen.cols() < 2) return {};
  const Eigen::VectorXd mean = seen.rowwise().mean();
  const Eigen::MatrixXd centred = seen.colwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(centred * centred.transpose() /
                                                             static_cast<double>(seen.cols()));
  LeftOutEnergy best;
  for (std::size_t count = 1; count <= components; count = count < 4 ? count + 1 : count + count / 4) {
    for (const double noise_mm : {0.03, 0.1, 0.3, 1.0}) {
      const LeftOutEnergy energy =
          foretell(eigen, mean, asked, hidden_groups, static_cast<Eigen::Index>(count), noise_mm * noise_mm);
      if (best.samples == 0 || energy.left_mm2 < best.left_mm2) best = energy;
    }
  }
  return best;
}

}  // namespace risorius::bench
