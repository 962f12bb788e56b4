#include "bench/left_out_markers.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "replay/performer/random.h"
#include "solve/au_solver.h"

namespace risorius::bench {
namespace {

constexpr double kComponentNoise_mm2 = 0.01;  // keeps components that few markers see from running away

std::vector<std::size_t> draw_hidden(const Rig& rig, int hidden, Random& random) {
  std::vector<std::size_t> order(rig.marker_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rig.neutral_mm(1, static_cast<Eigen::Index>(a)) < rig.neutral_mm(1, static_cast<Eigen::Index>(b));
  });
  std::vector<std::size_t> chosen;
  for (int band = 0; band < hidden; ++band) {
    const std::size_t from = order.size() * static_cast<std::size_t>(band) / static_cast<std::size_t>(hidden);
    const std::size_t to = order.size() * static_cast<std::size_t>(band + 1) / static_cast<std::size_t>(hidden);
    chosen.push_back(order[from + random.index(to - from)]);
  }
  return chosen;
}

RigidTransform head_from_world_of(const AuFrame& frame) {
  RigidTransform pose;
  pose.rotation = Eigen::Quaterniond(frame.world_from_head.rotation_xyzw.data());
  pose.translation = Eigen::Vector3d(frame.world_from_head.translation_mm.data());
  return pose.inverse();
}

/// 3M x T about the neutral, in the head's frame as the rig with all markers finds it; NaN where not measured.
Eigen::MatrixXd displacements(const Rig& rig, const MarkerSet& markers, const std::vector<MarkerFrame>& frames) {
  AuSolver solver(rig);
  solver.use_marker_set(markers);
  const std::vector<int> index = index_map(markers.names, rig.marker_names);
  Eigen::MatrixXd y = Eigen::MatrixXd::Constant(3 * rig.neutral_mm.cols(), static_cast<Eigen::Index>(frames.size()),
                                                std::numeric_limits<double>::quiet_NaN());
  AuFrame out;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    solver.push(frames[f]);
    solver.pop(out);
    const RigidTransform head_from_world = head_from_world_of(out);
    for (Eigen::Index m = 0; m < rig.neutral_mm.cols(); ++m) {
      const int i = index[static_cast<std::size_t>(m)];
      if (i < 0 || frames[f].state[static_cast<std::size_t>(i)] != MarkerState::kMeasured) continue;
      const Position& p = frames[f].position_mm[static_cast<std::size_t>(i)];
      y.block<3, 1>(3 * m, static_cast<Eigen::Index>(f)) =
          head_from_world * Eigen::Vector3d(p.x, p.y, p.z) - rig.neutral_mm.col(m);
    }
  }
  return y;
}

/// What the components say of all markers, from those that are not hidden.
Eigen::MatrixXd by_components(const Eigen::MatrixXd& y, const Eigen::MatrixXd& basis, const Eigen::VectorXd& mean,
                              const Eigen::VectorXd& variance, const std::vector<std::size_t>& hidden) {
  Eigen::VectorXd seen = Eigen::VectorXd::Ones(y.rows());
  for (const std::size_t m : hidden) seen.segment<3>(3 * static_cast<Eigen::Index>(m)).setZero();
  Eigen::MatrixXd h = basis.transpose() * seen.asDiagonal() * basis;
  h.diagonal().array() += kComponentNoise_mm2 / (variance.array() + 1e-9);
  const Eigen::MatrixXd centred = seen.asDiagonal() * (y.colwise() - mean);
  return (basis * h.llt().solve(basis.transpose() * centred)).colwise() + mean;
}

}  // namespace

LeftOutEnergy left_out_energy(const Rig& rig, const MarkerSet& markers, const std::vector<MarkerFrame>& frames,
                              int hidden, int draws, std::uint64_t seed) {
  const Eigen::MatrixXd y = displacements(rig, markers, frames);
  const Eigen::Index half = y.cols() / 2, rest = y.cols() - half;
  const Eigen::MatrixXd first = y.leftCols(half).unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
  const Eigen::MatrixXd second = y.rightCols(rest).unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
  const Eigen::VectorXd mean = first.rowwise().mean();
  const Eigen::MatrixXd centred = first.colwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(centred * centred.transpose() / static_cast<double>(half));
  LeftOutEnergy energy;
  energy.components = static_cast<int>(std::min<Eigen::Index>(static_cast<Eigen::Index>(rig.au_count()), y.rows()));
  const Eigen::MatrixXd basis = eigen.eigenvectors().rightCols(energy.components);
  const Eigen::VectorXd variance = eigen.eigenvalues().tail(energy.components);
  const std::vector<int> index = index_map(markers.names, rig.marker_names);
  Random random(seed, 5);
  double all = 0, missed_by_rig = 0, missed_by_components = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const std::vector<std::size_t> gone = draw_hidden(rig, hidden, random);
    const Eigen::MatrixXd components = by_components(second, basis, mean, variance, gone);
    AuSolver solver(rig);
    solver.use_marker_set(markers);
    AuFrame out;
    Eigen::Matrix3Xd predicted(3, rig.neutral_mm.cols());
    for (Eigen::Index f = 0; f < rest; ++f) {
      MarkerFrame frame = frames[static_cast<std::size_t>(half + f)];
      for (const std::size_t m : gone) {
        if (index[m] >= 0) frame.state[static_cast<std::size_t>(index[m])] = MarkerState::kMissing;
      }
      solver.push(frame);
      solver.pop(out);
      solver.predict_markers(predicted);
      const RigidTransform head_from_world = head_from_world_of(out);
      for (const std::size_t marker : gone) {
        const auto m = static_cast<Eigen::Index>(marker);
        const Eigen::Vector3d seen = y.block<3, 1>(3 * m, half + f);
        if (!seen.allFinite()) continue;
        const Eigen::Vector3d solved = head_from_world * Eigen::Vector3d(predicted.col(m)) - rig.neutral_mm.col(m);
        all += seen.squaredNorm();
        missed_by_rig += (solved - seen).squaredNorm();
        missed_by_components += (components.block<3, 1>(3 * m, f) - seen).squaredNorm();
      }
    }
  }
  energy.by_rig = 1 - missed_by_rig / all;
  energy.by_components = 1 - missed_by_components / all;
  return energy;
}

}  // namespace risorius::bench
