#include "solve/head_pose.h"

#include <array>
#include <fmt/format.h>
#include <random>
#include <stdexcept>

#include "capture/check.h"
#include "solve/robust_weight.h"

namespace risorius {
namespace {

/// Below this share of its weight a stabiliser no longer counts as one of the three that determine a pose.
constexpr double kLeastTrust = 1e-3;
/// The threshold follows the stabilisers' own unrest: 3 x 1.4826 is three standard deviations of a normal distribution.
constexpr double kMediansToThreshold = 3 * 1.4826;
/// The start is good, so the steepest loss may be used at once.
constexpr int kPower = 4;
/// In thresholds: how far off counts as far as can be, when triples are compared.
constexpr double kTruncation = 2;
/// All triples of up to 8 stabilisers. Of more: were 30 % false, 56 draws would all hold a false one with odds 6e-11.
constexpr int kMaxTriples = 56;

const HeadPoseOptions& checked(const HeadPoseOptions& options) {
  if (!(options.robust_threshold_mm > 0 && options.robust_threshold_mm <= 100)) {
    throw std::invalid_argument(
        fmt::format("HeadPoseOptions.robust_threshold_mm {} is not in (0, 100]", options.robust_threshold_mm));
  }
  if (options.iterations < 1 || options.iterations > 50) {
    throw std::invalid_argument(fmt::format("HeadPoseOptions.iterations {} is not in 1 to 50", options.iterations));
  }
  return options;
}

}  // namespace

HeadPose::HeadPose(std::size_t capacity, const HeadPoseOptions& options)
    : options_(checked(options)), trusted_weight_(capacity), distance_mm_(capacity), scratch_(capacity) {
  usable_.reserve(capacity);
}

HeadPoseResult HeadPose::estimate(std::span<const Eigen::Vector3d> head_mm, std::span<const Eigen::Vector3d> world_mm,
                                  std::span<const double> weights) noexcept {
  const std::size_t count = head_mm.size();
  RISORIUS_CHECK(count <= trusted_weight_.size() && world_mm.size() == count && weights.size() == count);
  const Points points{head_mm, world_mm, weights};
  usable_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (weights[i] > 0) usable_.push_back(static_cast<int>(i));
  }
  RigidAlignment alignment = align_rigid(head_mm, world_mm, weights);
  if (!alignment.determined) return {alignment.to_from, alignment.rms, false};
  measure_distances(points, alignment.to_from);
  double furthest = 0;
  for (const int i : usable_) furthest = std::max(furthest, distance_mm_[i]);
  if (furthest > options_.robust_threshold_mm) alignment = reweigh(points, best_triple(points, alignment));
  return {alignment.to_from, alignment.rms, alignment.determined};
}

void HeadPose::measure_distances(const Points& points, const RigidTransform& world_from_head) noexcept {
  for (const int i : usable_) distance_mm_[i] = (world_from_head * points.head_mm[i] - points.world_mm[i]).norm();
}

/// Or `all`, if no triple explains more. All triples where they are few, else a fixed pseudo-random choice of them.
RigidAlignment HeadPose::best_triple(const Points& points, const RigidAlignment& all) noexcept {
  RigidAlignment best = all;
  double least = truncated_squares(points, all.to_from);
  const int n = static_cast<int>(usable_.size());
  const auto consider = [&](int a, int b, int c) {
    const RigidAlignment candidate = align_triple(points, usable_[a], usable_[b], usable_[c]);
    if (!candidate.determined) return;
    const double cost = truncated_squares(points, candidate.to_from);
    if (!(cost < least)) return;
    least = cost;
    best = candidate;
  };
  if (n * (n - 1) * (n - 2) / 6 <= kMaxTriples) {
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        for (int c = b + 1; c < n; ++c) consider(a, b, c);
      }
    }
    return best;
  }
  std::minstd_rand random(1);
  for (int triple = 0; triple < kMaxTriples; ++triple) {
    const int a = static_cast<int>(random() % n), b = static_cast<int>(random() % n),
              c = static_cast<int>(random() % n);
    if (a != b && b != c && a != c) consider(a, b, c);
  }
  return best;
}

RigidAlignment HeadPose::align_triple(const Points& points, int a, int b, int c) noexcept {
  const std::array head{points.head_mm[a], points.head_mm[b], points.head_mm[c]};
  const std::array world{points.world_mm[a], points.world_mm[b], points.world_mm[c]};
  constexpr std::array kEqual{1.0, 1.0, 1.0};
  return align_rigid(head, world, kEqual);
}

double HeadPose::truncated_squares(const Points& points, const RigidTransform& world_from_head) noexcept {
  measure_distances(points, world_from_head);
  double sum = 0;
  for (const int i : usable_) {
    const double distance = std::min(distance_mm_[i], kTruncation * options_.robust_threshold_mm);
    sum += points.weights[i] * distance * distance;
  }
  return sum;
}

RigidAlignment HeadPose::reweigh(const Points& points, RigidAlignment alignment) noexcept {
  const std::span<double> trusted = std::span(trusted_weight_).first(points.weights.size());
  for (int iteration = 0; iteration < options_.iterations && alignment.determined; ++iteration) {
    measure_distances(points, alignment.to_from);
    const double limit = threshold(points.weights);
    std::fill(trusted.begin(), trusted.end(), 0);
    for (const int i : usable_) {
      const double trust = robust_weight(distance_mm_[i], limit, kPower);
      trusted[i] = trust < kLeastTrust ? 0 : trust * points.weights[i];
    }
    alignment = align_rigid(points.head_mm, points.world_mm, trusted);
  }
  return alignment;
}

double HeadPose::threshold(std::span<const double> weights) noexcept {
  std::size_t used = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) scratch_[used++] = distance_mm_[i];
  }
  return std::max(options_.robust_threshold_mm, kMediansToThreshold * lower_median(std::span(scratch_).first(used)));
}

}  // namespace risorius
