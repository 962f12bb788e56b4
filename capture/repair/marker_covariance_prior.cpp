// What a MarkerCovariance believes before it has learnt anything.
#include <cmath>

#include "capture/repair/marker_covariance.h"
#include "capture/repair/symmetric_sweep.h"

namespace risorius {
namespace {

/// The first belief is made ready in as many frames as it takes at this many multiplications each: at once for a face
/// of some 60 markers, in seconds for the most that there can be.
constexpr Eigen::Index kPriorWork = 4'000'000;

}  // namespace

/// The first frame says who is whose neighbour. Markers that come later have none, and learn it.
void MarkerCovariance::begin_prior() noexcept {
  if (!is_informative()) return;
  const double alike = options_.prior_samples * options_.alike_mm * options_.alike_mm;
  swept_.setZero();
  swept_.diagonal().setConstant(ridge());
  for (std::size_t j = 0; j < markers_.size(); ++j) {
    for (std::size_t i = j + 1; i < markers_.size(); ++i) {
      if (!markers_[i].seen || !markers_[j].seen) continue;
      const double apart = (markers_[i].rest_mm - markers_[j].rest_mm).norm() / options_.reach_mm;
      swept_.block<3, 3>(at(i), at(j)).diagonal().setConstant(alike * std::exp(-apart * apart / 2));
    }
  }
  next_pivot_ = 0;
  prior_ = Prior::kOnItsWay;
}

void MarkerCovariance::go_on_with_prior() noexcept {
  const Eigen::Index size = swept_.cols();
  for (Eigen::Index work = kPriorWork; work > 0 && next_pivot_ < size; work -= size * size / 2) {
    sweep_pivot(swept_, next_pivot_++, direction_);
  }
  if (next_pivot_ < size) return;
  negate_whole(swept_, precision_);
  prior_ = Prior::kThere;
}

}  // namespace risorius
