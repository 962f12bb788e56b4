#include "capture/repair/baselines/held_marker.h"

#include <algorithm>
#include <cmath>

namespace risorius {
namespace {

constexpr double kVelocitySmoothingS = 0.05;
constexpr double kMemorySamples = 600;

}  // namespace

void HeldMarker::observe(const Eigen::Vector3d& position_mm, double step_s) noexcept {
  if (!seen_) mean_mm_ = position_mm;
  if (seen_ && gap_s_ == 0) {
    const Eigen::Vector3d moved = position_mm - position_mm_;
    const double rate = 1 - std::exp(-step_s / kVelocitySmoothingS);
    velocity_mm_s_ += rate * (moved / step_s - velocity_mm_s_);
    step_mm2_ += (moved.squaredNorm() / 3 - step_mm2_) / (std::min(samples_, kMemorySamples) + 10);
  } else {
    velocity_mm_s_.setZero();
  }
  samples_ += 1;
  step_s_ = step_s;
  const double rate = 1 / std::min(samples_, kMemorySamples);
  mean_mm_ += rate * (position_mm - mean_mm_);
  spread_mm2_ += rate * ((position_mm - mean_mm_).squaredNorm() / 3 - spread_mm2_);
  position_mm_ = position_mm;
  gap_s_ = 0;
  seen_ = true;
}

Eigen::Vector3d HeldMarker::damped_mm() const noexcept {
  return position_mm_ + kDampingS * (1 - std::exp(-gap_s_ / kDampingS)) * velocity_mm_s_;
}

double HeldMarker::variance_mm2() const noexcept {
  // Movement goes on for a while, so early on the error grows with the square of the gap; it ends at twice the spread
  // (two independent moments of the same marker).
  const double frames = gap_s_ / step_s_;
  return std::min(step_mm2_ * frames * frames, 2 * spread_mm2_ + step_mm2_);
}

}  // namespace risorius
