#include "capture/repair/baselines/interpolation.h"

#include <cmath>

#include "capture/repair/head_take.h"
#include "capture/repair/position_vector.h"

namespace risorius {
namespace {

/// Mean squared step of marker i between neighbouring measured frames, per axis.
double step_variance_mm2(const std::vector<MarkerFrame>& frames, std::size_t i) noexcept {
  double squared = 0, steps = 0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    if (frames[f].state[i] != MarkerState::kMeasured || frames[f - 1].state[i] != MarkerState::kMeasured) continue;
    squared += (to_vector(frames[f].position_mm[i]) - to_vector(frames[f - 1].position_mm[i])).squaredNorm();
    steps += 3;
  }
  return steps > 0 ? squared / steps : 0;
}

double walk_deviation_mm(double step_mm2, double length, double share) noexcept {
  return std::sqrt(step_mm2 * length * share * (1 - share));
}

/// The gaps of marker i between two measured samples, `fill_gap(before, after)`.
template <class FillGap>
void for_each_gap(const std::vector<MarkerFrame>& frames, std::size_t i, std::int64_t max_gap_ns, FillGap fill_gap) {
  std::size_t before = frames.size();  // none yet
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (i >= frames[f].count || frames[f].state[i] != MarkerState::kMeasured) continue;
    const bool is_gap = before < f && f > before + 1;
    if (is_gap && frames[f].header.capture_time_ns - frames[before].header.capture_time_ns <= max_gap_ns) {
      fill_gap(before, f);
    }
    before = f;
  }
}

/// `position(f, share)` says where the marker is in frame f, in the world.
template <class PositionOf>
void fill_gap(std::vector<MarkerFrame>& frames, std::size_t i, std::size_t before, std::size_t after, double step_mm2,
              PositionOf position) {
  const auto length = static_cast<double>(after - before);
  for (std::size_t f = before + 1; f < after; ++f) {
    const double share = static_cast<double>(f - before) / length;
    frames[f].position_mm[i] = to_position(position(f, share));
    frames[f].state[i] = MarkerState::kFilled;
    frames[f].standard_deviation_mm[i] = static_cast<float>(walk_deviation_mm(step_mm2, length, share));
  }
}

std::size_t marker_count(const std::vector<MarkerFrame>& frames) noexcept {
  return frames.empty() ? 0 : frames.front().count;
}

/// The cubic through four samples (Lagrange).
Eigen::Vector3d cubic(const std::array<double, 4>& t, const std::array<Eigen::Vector3d, 4>& p, double at) noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    double weight = 1;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != k) weight *= (at - t[j]) / (t[k] - t[j]);
    }
    sum += weight * p[k];
  }
  return sum;
}

}  // namespace

void fill_linear(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns) {
  for (std::size_t i = 0; i < marker_count(frames); ++i) {
    const double step_mm2 = step_variance_mm2(frames, i);
    for_each_gap(frames, i, max_gap_ns, [&](std::size_t before, std::size_t after) {
      const Eigen::Vector3d from = to_vector(frames[before].position_mm[i]),
                            to = to_vector(frames[after].position_mm[i]);
      fill_gap(frames, i, before, after, step_mm2,
               [&](std::size_t, double share) -> Eigen::Vector3d { return (1 - share) * from + share * to; });
    });
  }
}

void fill_linear_in_head(std::vector<MarkerFrame>& frames, const MarkerSet& set, std::int64_t max_gap_ns) {
  const HeadTake take = carry_into_head_frame(frames, set, {});
  for (std::size_t i = 0; i < marker_count(frames); ++i) {
    const double step_mm2 = step_variance_mm2(frames, i);
    for_each_gap(frames, i, max_gap_ns, [&](std::size_t before, std::size_t after) {
      const Eigen::Vector3d& from = take.position_mm[take.at(before, i)];
      const Eigen::Vector3d& to = take.position_mm[take.at(after, i)];
      fill_gap(frames, i, before, after, step_mm2, [&](std::size_t f, double share) -> Eigen::Vector3d {
        return take.head_from_world[f].inverse() * ((1 - share) * from + share * to);
      });
    });
  }
}

void fill_cubic(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns) {
  for (std::size_t i = 0; i < marker_count(frames); ++i) {
    const double step_mm2 = step_variance_mm2(frames, i);
    const auto measured = [&](std::size_t f) { return frames[f].state[i] == MarkerState::kMeasured; };
    for_each_gap(frames, i, max_gap_ns, [&](std::size_t before, std::size_t after) {
      const bool is_open = before > 0 && measured(before - 1) && after + 1 < frames.size() && measured(after + 1);
      const std::array<std::size_t, 4> at =
          is_open ? std::array{before - 1, before, after, after + 1} : std::array{before, before, after, after};
      std::array<double, 4> t{};
      std::array<Eigen::Vector3d, 4> p;
      for (std::size_t k = 0; k < 4; ++k) {
        t[k] = static_cast<double>(at[k]);
        p[k] = to_vector(frames[at[k]].position_mm[i]);
      }
      fill_gap(frames, i, before, after, step_mm2, [&](std::size_t f, double share) -> Eigen::Vector3d {
        return is_open ? cubic(t, p, static_cast<double>(f)) : (1 - share) * p[1] + share * p[2];
      });
    });
  }
}

}  // namespace risorius
