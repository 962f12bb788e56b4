#include "solve/rigs/rig_check.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "capture/marker_set.h"
#include "solve/rigs/marker_rigidity.h"

namespace risorius {
namespace {

constexpr double kAtBound = 1e-6;
constexpr double kOftenAtBound = 0.25;  // of the frames: the maximum of the rig is not the actor's
constexpr double kLeastSolved = 0.9;    // of the frames
constexpr double kPoorResidualMm = 3;
constexpr double kRidgeOfPrior = 1 / (0.5 * 0.5);  // intensities are not known better than 0.5 beforehand

/// How often each marker is seen, 0 to 1 (M).
Eigen::VectorXd presence_of(const Rig& rig, const TakeFrames& take) {
  const std::vector<int> index = index_map(take.markers.names, rig.marker_names);
  Eigen::VectorXd presence = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(index.size()));
  for (const MarkerFrame& frame : take.frames) {
    for (std::size_t m = 0; m < index.size(); ++m) {
      if (index[m] < 0 || frame.state[static_cast<std::size_t>(index[m])] != MarkerState::kMeasured) continue;
      presence[static_cast<Eigen::Index>(m)] += 1.0 / static_cast<double>(take.frames.size());
    }
  }
  return presence;
}

/// Columns (3M x K) under the root of the markers' weights, less what a small motion of the head explains of them.
Eigen::MatrixXd columns_without_pose(const Rig& rig, const Eigen::VectorXd& weight) {
  const auto markers = static_cast<Eigen::Index>(rig.marker_count());
  const Eigen::Vector3d centre = rig.neutral_mm.rowwise().mean();
  Eigen::MatrixXd pose(3 * markers, 6), columns(3 * markers, static_cast<Eigen::Index>(rig.au_count()));
  for (Eigen::Index m = 0; m < markers; ++m) {
    const double root = std::sqrt(weight[m]);
    const Eigen::Vector3d arm = (rig.neutral_mm.col(m) - centre) / 50;  // of about the same size as a shift
    pose.block<3, 3>(3 * m, 0) = root * Eigen::Matrix3d::Identity();
    for (int axis = 0; axis < 3; ++axis) {
      pose.block<3, 1>(3 * m, 3 + axis) = root * Eigen::Vector3d(Eigen::Vector3d::Unit(axis).cross(arm));
    }
    for (std::size_t i = 0; i < rig.au_count(); ++i) {
      columns.block<3, 1>(3 * m, static_cast<Eigen::Index>(i)) = root * rig.aus[i].displacement_mm.col(m);
    }
  }
  return columns - pose * pose.colPivHouseholderQr().solve(columns);
}

/// Intensities over the take, and what is left of the markers.
struct Explained {
  std::vector<std::vector<double>> intensity;
  std::vector<std::size_t> at_bound;
  std::vector<double> axis_mm;
  double squares = 0, samples = 0;
  StatusTally statuses{};
};

Explained explain(const Rig& rig, const TakeFrames& take, const AuSolverOptions& options) {
  Explained result{.intensity = std::vector<std::vector<double>>(rig.au_count()),
                   .at_bound = std::vector<std::size_t>(rig.au_count(), 0)};
  result.statuses = explain_take(rig, take, options, [&](const ExplainedFrame& frame) {
    for (std::size_t i = 0; i < rig.au_count(); ++i) {
      const double x = frame.x[static_cast<Eigen::Index>(i)];
      if (!frame.observed[i]) continue;
      result.intensity[i].push_back(x);
      result.at_bound[i] += x >= rig.aus[i].upper_bound - kAtBound;
    }
    for (Eigen::Index m = 0; m < frame.measured.size(); ++m) {
      if (frame.measured[m] == 0) continue;
      result.squares += frame.residual_mm.col(m).squaredNorm();
      result.samples += 1;
      for (const double r : frame.residual_mm.col(m)) result.axis_mm.push_back(std::abs(r));
    }
  });
  return result;
}

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void compare_columns(const Rig& rig, const Eigen::VectorXd& presence, const RigCheckOptions& options, RigCheck& check) {
  // Stabilisers hold the head in the solve with six times the weight of other markers.
  Eigen::VectorXd weight = presence;
  for (Eigen::Index m = 0; m < weight.size(); ++m) weight[m] *= rig.stabiliser_weight[m] > 0 ? 6 : 1;
  const Eigen::MatrixXd columns = columns_without_pose(rig, weight);
  const Eigen::VectorXd norms = columns.colwise().norm().cwiseMax(1e-9);
  check.cosines =
      (columns * norms.cwiseInverse().asDiagonal()).transpose() * (columns * norms.cwiseInverse().asDiagonal());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(check.cosines, Eigen::EigenvaluesOnly);
  check.condition = eigen.eigenvalues().maxCoeff() / std::max(eigen.eigenvalues()[0], 1e-12);
  Eigen::MatrixXd information = columns.transpose() * columns / (check.noise_mm * check.noise_mm);
  information.diagonal().array() += kRidgeOfPrior;
  const Eigen::VectorXd variance = information.inverse().diagonal();
  const auto count = static_cast<Eigen::Index>(rig.au_count());
  for (Eigen::Index i = 0; i < count; ++i) {
    AuCheck& au = check.aus[static_cast<std::size_t>(i)];
    au.deviation = std::sqrt(variance[i]);
    au.alone_deviation = 1 / std::sqrt(information(i, i));
    au.weak = au.deviation > options.largest_deviation;
    for (Eigen::Index j = 0; j < count; ++j) {
      if (j == i || !(check.cosines(i, j) > au.cosine)) continue;
      au.cosine = check.cosines(i, j);
      au.most_like = rig.aus[static_cast<std::size_t>(j)].name;
    }
    for (Eigen::Index j = i + 1; j < count; ++j) {
      if (check.cosines(i, j) <= options.confused_cosine) continue;
      check.confused.push_back({au.au, rig.aus[static_cast<std::size_t>(j)].name, check.cosines(i, j)});
    }
  }
  std::ranges::stable_sort(check.confused, std::greater<>(), &ConfusedPair::cosine);
}

void compare_markers(const Rig& rig, const TakeFrames& take, const Eigen::VectorXd& presence, RigCheck& check) {
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    if (presence[static_cast<Eigen::Index>(m)] == 0) check.missing_markers.push_back(rig.marker_names[m]);
  }
  for (const std::string& name : take.markers.names) {
    if (std::ranges::find(rig.marker_names, name) == rig.marker_names.end()) check.unknown_markers.push_back(name);
  }
  const Eigen::VectorXd unrest_mm = marker_unrest_mm(rig, take);
  check.unrest_mm.assign(unrest_mm.begin(), unrest_mm.end());
}

void judge(const Rig& rig, const Explained& explained, const RigCheckOptions& options, RigCheck& check) {
  const auto count = [&](SolverStatus status) { return explained.statuses[static_cast<std::size_t>(status)]; };
  if (2 * count(SolverStatus::kMirrored) > check.frames) {
    check.problems.push_back("the take is mirrored against the rig: one letter of --axes is wrong");
  } else if (2 * count(SolverStatus::kPoorFit) > check.frames) {
    check.problems.push_back("the rig cannot be this face in this unit: another actor's take, or --units is wrong");
  } else if (static_cast<double>(check.solved) < kLeastSolved * static_cast<double>(check.frames)) {
    check.problems.push_back(
        fmt::format("{} of {} frames could not be solved", check.frames - check.solved, check.frames));
  }
  if (check.solved > 0 && check.residual_rms_mm > kPoorResidualMm) {
    check.warnings.push_back(fmt::format(
        "the rig leaves {:.1f} mm of each marker (rms): refine it on this actor's takes", check.residual_rms_mm));
  }
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    if (rig.stabiliser_weight[static_cast<Eigen::Index>(m)] == 0 || !(check.unrest_mm[m] > options.unrest_mm)) continue;
    check.warnings.push_back(
        fmt::format("stabiliser {} moves against the head by {:.1f} mm (rms): it moves with the "
                    "face or has slipped (rig refine chooses others)",
                    rig.marker_names[m], check.unrest_mm[m]));
  }
  if (!check.missing_markers.empty()) {
    check.warnings.push_back(fmt::format("never seen in the take: {}", fmt::join(check.missing_markers, " ")));
  }
  if (!check.unknown_markers.empty()) {
    check.warnings.push_back(fmt::format("not in the rig, ignored: {}", fmt::join(check.unknown_markers, " ")));
  }
  std::vector<std::string> often;
  for (const AuCheck& au : check.aus) {
    if (au.at_bound_share > kOftenAtBound) often.push_back(fmt::format("{} {:.0f} %", au.au, 100 * au.at_bound_share));
  }
  if (!often.empty()) {
    check.warnings.push_back(
        fmt::format("at the upper bound in many frames (neutral or basis is off): {}", fmt::join(often, ", ")));
  }
}

}  // namespace

RigCheck check_rig(const Rig& rig, const TakeFrames& take, const RigCheckOptions& options) {
  RigCheck check;
  for (const RigAu& au : rig.aus) check.aus.push_back({.au = au.name});
  Explained explained = explain(rig, take, options.solve);
  check.frames = take.frames.size();
  check.solved = explained.statuses[static_cast<std::size_t>(SolverStatus::kConverged)];
  check.residual_rms_mm = explained.samples > 0 ? std::sqrt(explained.squares / explained.samples) : 0;
  check.noise_mm = std::max(quantile(explained.axis_mm, 0.5) / 0.6745, options.least_noise_mm);
  const Eigen::VectorXd presence = presence_of(rig, take);
  compare_columns(rig, presence, options, check);
  compare_markers(rig, take, presence, check);
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    AuCheck& au = check.aus[i];
    const Eigen::VectorXd energy = rig.aus[i].displacement_mm.colwise().squaredNorm();
    au.seen_share = energy.dot(presence) / energy.sum();
    au.peak = quantile(explained.intensity[i], 0.98);
    au.at_bound_share =
        static_cast<double>(explained.at_bound[i]) / static_cast<double>(std::max<std::size_t>(1, check.solved));
  }
  judge(rig, explained, options, check);
  return check;
}

}  // namespace risorius
