#include "capture/repair/gap_baselines.h"

#include <algorithm>
#include <cmath>

namespace risorius {
namespace {

constexpr double kVelocitySmoothingS = 0.05;
constexpr double kMemorySamples = 600;

Eigen::Vector3d vector_of(Position p) noexcept { return {p.x, p.y, p.z}; }

/// Mean squared step of marker i between neighbouring measured frames, per axis.
double step_variance_mm2(const std::vector<MarkerFrame>& frames, std::size_t i) noexcept {
  double squared = 0, steps = 0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    if (frames[f].state[i] != MarkerState::kMeasured || frames[f - 1].state[i] != MarkerState::kMeasured) continue;
    squared += (vector_of(frames[f].position_mm[i]) - vector_of(frames[f - 1].position_mm[i])).squaredNorm();
    steps += 3;
  }
  return steps > 0 ? squared / steps : 0;
}

void fill_between(std::vector<MarkerFrame>& frames, std::size_t i, std::size_t before, std::size_t after,
                  double step_mm2) noexcept {
  const Eigen::Vector3d from = vector_of(frames[before].position_mm[i]), to = vector_of(frames[after].position_mm[i]);
  const auto length = static_cast<double>(after - before);
  for (std::size_t f = before + 1; f < after; ++f) {
    const double share = static_cast<double>(f - before) / length;
    const Eigen::Vector3f p = ((1 - share) * from + share * to).cast<float>();
    frames[f].position_mm[i] = {p.x(), p.y(), p.z()};
    frames[f].state[i] = MarkerState::kFilled;
    frames[f].standard_deviation_mm[i] = static_cast<float>(std::sqrt(step_mm2 * length * share * (1 - share)));
  }
}

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

void fill_linear(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns) {
  if (frames.empty()) return;
  for (std::size_t i = 0; i < frames.front().count; ++i) {
    const double step_mm2 = step_variance_mm2(frames, i);
    std::size_t before = frames.size();
    for (std::size_t f = 0; f < frames.size(); ++f) {
      if (frames[f].state[i] != MarkerState::kMeasured) continue;
      const bool gap = before < frames.size() && f > before + 1;
      if (gap && frames[f].header.capture_time_ns - frames[before].header.capture_time_ns <= max_gap_ns) {
        fill_between(frames, i, before, f, step_mm2);
      }
      before = f;
    }
  }
}

}  // namespace risorius
