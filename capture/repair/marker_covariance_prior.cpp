// What a MarkerCovariance believes before it has learnt anything.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/frames.h"
#include "capture/repair/cholesky.h"
#include "capture/repair/marker_covariance.h"

namespace risorius {
namespace {

/// A new marker is believed to depend on so many neighbours; on all others only through these (Vecchia 1988).
constexpr std::size_t kMostNeighbours = 16;
constexpr Eigen::Index kMostCoordinates = 3 * kMostNeighbours;

}  // namespace

/// Of the deviations of markers i and j that were seen: neighbours move alike, and as it is known of this face.
Eigen::Matrix3d MarkerCovariance::believed_mm2(std::size_t i, std::size_t j) const noexcept {
  // By marker and not by pair: a covariance must stay one where some of the markers are known and some are not.
  const auto share_of = [this](std::size_t m) { return modes_.knows(m) ? std::sqrt(options_.unknown_share) : 1; };
  const double share = share_of(i) * share_of(j);
  const double apart = (markers_[i].rest_mm - markers_[j].rest_mm).norm() / options_.reach_mm;
  double alike = share * options_.alike_mm * options_.alike_mm * std::exp(-apart * apart / 2);
  if (i == j) alike += share * options_.alone_mm * options_.alone_mm;
  Eigen::Matrix3d believed = alike * Eigen::Matrix3d::Identity();
  if (modes_.knows(i) && modes_.knows(j)) {
    believed += options_.mode_strength * options_.mode_strength * modes_.of(i).transpose().lazyProduct(modes_.of(j));
  }
  return believed;
}

/// Marker i, of which nothing stands in P but its ridge, is given its neighbours w d plus a rest of covariance C:
/// P += (i - w)^T (n0 C)^-1 (i - w), which leaves what is believed of the others as it is.
void MarkerCovariance::believe(std::size_t i) noexcept {
  std::array<std::pair<double, std::size_t>, kMaxMarkers> others;
  std::size_t count = 0;
  for (std::size_t j = 0; j < markers_.size(); ++j) {
    if (j != i && markers_[j].believed) {
      others[count++] = {(markers_[i].rest_mm - markers_[j].rest_mm).squaredNorm(), j};
    }
  }
  const std::size_t near = std::min(count, kMostNeighbours);
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(near),
                    others.begin() + static_cast<std::ptrdiff_t>(count));
  std::array<double, kMostCoordinates * kMostCoordinates> room;
  const auto size = static_cast<Eigen::Index>(3 * near);
  Eigen::Map<Eigen::MatrixXd> among(room.data(), size, size);
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostCoordinates, 3> share(size, 3);
  for (std::size_t c = 0; c < near; ++c) {
    for (std::size_t r = c; r < near; ++r) {
      among.block<3, 3>(at(r), at(c)) = believed_mm2(others[r].second, others[c].second);
    }
    share.middleRows<3>(at(c)) = believed_mm2(others[c].second, i);
  }
  factorize_lower(among);
  const Eigen::Map<const Eigen::MatrixXd> factor(room.data(), size, size);
  solve_lower(factor, share);
  const Eigen::Matrix3d rest_mm2 = believed_mm2(i, i) - share.transpose().lazyProduct(share);
  for (Eigen::Index axis = 0; axis < 3; ++axis) solve_lower_transposed(factor, share.col(axis));
  Eigen::Matrix3d own = (options_.prior_samples * rest_mm2).inverse();
  own = (0.5 * (own + own.transpose())).eval();
  precision_.block<3, 3>(at(i), at(i)) = own;
  for (std::size_t c = 0; c < near; ++c) {
    const Eigen::Matrix3d pull = share.middleRows<3>(at(c)) * own;
    precision_.block<3, 3>(at(others[c].second), at(i)) = -pull;
    precision_.block<3, 3>(at(i), at(others[c].second)) = -pull.transpose();
    for (std::size_t r = 0; r <= c; ++r) {
      Eigen::Matrix3d both = pull * share.middleRows<3>(at(r)).transpose();
      if (r == c) both = (0.5 * (both + both.transpose())).eval();
      precision_.block<3, 3>(at(others[c].second), at(others[r].second)) += both;
      if (r < c) precision_.block<3, 3>(at(others[r].second), at(others[c].second)) += both.transpose();
    }
  }
  markers_[i].believed = true;
}

/// Markers that are seen for the first time.
void MarkerCovariance::believe_newcomers() noexcept {
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (markers_[i].seen) modes_.see(i, markers_[i].rest_mm);
  }
  modes_.align();
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (markers_[i].seen && !markers_[i].believed) believe(i);
  }
  must_condition_ = true;
}

}  // namespace risorius
