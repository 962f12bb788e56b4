// A small synthetic face for the tests of repair: markers on an ellipsoid that three smooth, seeded movements deform,
// with white noise, and a head that may move. The truth in the head's frame is known for every frame.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <string>
#include <vector>

#include "support/marker_csv.h"

namespace risorius::test {

struct SyntheticOptions {
  std::size_t markers = 24;
  std::size_t frames = 600;
  double rate_hz = 60;
  double noise_mm = 0.05;
  bool head_moves = false;  ///< 15 degrees and 40 mm, at about 1 Hz
  std::uint64_t seed = 1;
};

inline Eigen::Vector3d vector_of(Position p) { return {p.x, p.y, p.z}; }
inline Position position_of(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

inline Eigen::Isometry3d synthetic_head(double t) {
  Eigen::Isometry3d head = Eigen::Isometry3d::Identity();
  head.translate(Eigen::Vector3d(40 * std::sin(5.1 * t), 25 * std::sin(7 * t + 1), 30 * std::cos(6 * t)));
  head.rotate(Eigen::AngleAxisd(0.26 * std::sin(6.3 * t), Eigen::Vector3d(0.3, 1, 0.2).normalized()));
  return head;
}

inline MarkerTake synthetic_take(const SyntheticOptions& options = {}) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal(0, 1);
  MarkerTake take;
  take.set.rate_hz = options.rate_hz;
  std::vector<Eigen::Vector3d> rest(options.markers);
  std::vector<std::array<Eigen::Vector3d, 3>> modes(options.markers);
  for (std::size_t i = 0; i < options.markers; ++i) {
    take.set.names.push_back(fmt::format("M{}", i));
    const double height = -1 + 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(options.markers);
    const double turn = 2.4 * static_cast<double>(i);  // golden angle: an even spread
    const double radius = std::sqrt(1 - height * height);
    rest[i] = {70 * radius * std::cos(turn), 90 * height, 60 * radius * std::sin(turn)};
    // Only the lower half moves much, as in a face.
    for (auto& mode : modes[i]) {
      mode = (height < 0 ? 2.0 : 0.1) * Eigen::Vector3d(normal(random), normal(random), normal(random));
    }
  }
  for (std::size_t f = 0; f < options.frames; ++f) {
    const double t = static_cast<double>(f) / options.rate_hz;
    const double z[3] = {std::sin(4 * t), std::sin(2.7 * t + 1), std::sin(6.1 * t + 2)};
    const Eigen::Isometry3d head = options.head_moves ? synthetic_head(t) : Eigen::Isometry3d::Identity();
    MarkerFrame& frame = take.frames.emplace_back();
    frame.header.sequence = f;
    frame.header.capture_time_ns = std::llround(t * 1e9);
    frame.count = static_cast<std::uint32_t>(options.markers);
    for (std::size_t i = 0; i < options.markers; ++i) {
      Eigen::Vector3d p = rest[i] + options.noise_mm * Eigen::Vector3d(normal(random), normal(random), normal(random));
      for (std::size_t k = 0; k < 3; ++k) p += z[k] * modes[i][k];
      frame.state[i] = MarkerState::kMeasured;
      frame.position_mm[i] = position_of(head * p);
    }
  }
  return take;
}

inline void hide(MarkerTake& take, std::size_t marker, std::size_t first, std::size_t length) {
  for (std::size_t f = first; f < first + length; ++f) {
    take.frames[f].state[marker] = MarkerState::kMissing;
    take.frames[f].position_mm[marker] = {};
  }
}

/// Pushes and pops every frame.
template <class S>
std::vector<MarkerFrame> run_stage(S& stage, const std::vector<MarkerFrame>& frames) {
  std::vector<MarkerFrame> out;
  for (const MarkerFrame& frame : frames) {
    stage.push(frame);
    MarkerFrame& popped = out.emplace_back();
    if (!stage.pop(popped)) out.pop_back();
  }
  stage.flush();
  return out;
}

inline bool same_bits(const MarkerFrame& a, const MarkerFrame& b) {
  for (std::size_t i = 0; i < a.count; ++i) {
    if (a.state[i] != b.state[i] || a.reason[i] != b.reason[i]) return false;
    if (std::memcmp(&a.position_mm[i], &b.position_mm[i], sizeof(Position)) != 0) return false;
    if (a.standard_deviation_mm[i] != b.standard_deviation_mm[i]) return false;
  }
  return a.count == b.count;
}

}  // namespace risorius::test
