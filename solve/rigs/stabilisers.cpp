#include "solve/rigs/stabilisers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <numeric>

namespace risorius {
namespace {

constexpr std::size_t kFewest = 4, kMost = 6;
constexpr double kStillMm = 1;       // a marker that no AU moves further is as good as fixed
constexpr double kLeastWidthMm = 5;  // of the second axis of their spread

/// The largest displacement of each marker by any AU.
Eigen::VectorXd motion_of(Eigen::Index marker_count, const std::vector<RigAu>& aus) {
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(marker_count);
  for (const RigAu& au : aus) motion = motion.cwiseMax(au.displacement_mm.colwise().norm().transpose());
  return motion;
}

}  // namespace

std::vector<Eigen::Index> choose_stabilisers(const Eigen::Matrix3Xd& neutral_mm, const std::vector<RigAu>& aus) {
  const Eigen::VectorXd motion = motion_of(neutral_mm.cols(), aus);
  std::vector<Eigen::Index> calm(static_cast<std::size_t>(neutral_mm.cols()));
  std::iota(calm.begin(), calm.end(), 0);
  std::stable_sort(calm.begin(), calm.end(), [&](Eigen::Index a, Eigen::Index b) { return motion[a] < motion[b]; });
  std::size_t calm_count = std::min(calm.size(), std::max(kMost, calm.size() / 3));
  while (calm_count > kFewest && motion[calm[calm_count - 1]] > std::max(kStillMm, motion[calm[kFewest - 1]]))
    --calm_count;
  calm.resize(calm_count);

  std::vector<Eigen::Index> chosen;
  while (chosen.size() < kMost && chosen.size() < calm.size()) {
    Eigen::Index farthest = calm.front();
    double farthest_mm = -1;
    for (const Eigen::Index marker : calm) {
      double nearest_mm = chosen.empty() ? 0 : std::numeric_limits<double>::infinity();
      for (const Eigen::Index other : chosen) {
        nearest_mm = std::min(nearest_mm, (neutral_mm.col(marker) - neutral_mm.col(other)).norm());
      }
      if (nearest_mm > farthest_mm) farthest = marker, farthest_mm = nearest_mm;
    }
    chosen.push_back(farthest);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

bool hold_still(const Eigen::Matrix3Xd& neutral_mm, const Eigen::VectorXd& weights) {
  if ((weights.array() > 0).count() < 3) return false;
  const Eigen::VectorXd share = weights / weights.sum();
  const Eigen::Matrix3Xd centred = neutral_mm.colwise() - Eigen::Vector3d(neutral_mm * share);
  const Eigen::Matrix3d spread = centred * share.asDiagonal() * centred.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread, Eigen::EigenvaluesOnly);
  return axes.eigenvalues()[1] > kLeastWidthMm * kLeastWidthMm;
}

}  // namespace risorius
