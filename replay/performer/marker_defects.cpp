#include "replay/performer/marker_defects.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace risorius {
namespace {

// Gap lengths in seconds: log-normal, cut off. In optical face takes most gaps last a few frames, some whole seconds.
constexpr double kGapMedianS = 0.12, kGapSigma = 0.9, kLongestGapS = 2;
constexpr int kLongestFalseTrack = 7;  // frames, 1 to 7 equally likely
constexpr double kMeanFalseTrack = (1 + kLongestFalseTrack) / 2.0;
constexpr double kJumpShare = 0.5, kGhostShare = 0.3;  // the rest are swaps, which spoil two markers

double normal_distribution(double z) noexcept { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

/// E[min(gap, longest)] of the log-normal gap.
double mean_gap_s() noexcept {
  const double mu = std::log(kGapMedianS), cut = (std::log(kLongestGapS) - mu) / kGapSigma;
  return std::exp(mu + 0.5 * kGapSigma * kGapSigma) * normal_distribution(cut - kGapSigma) +
         kLongestGapS * (1 - normal_distribution(cut));
}

void require(double value, const char* name, double most) {
  if (value >= 0 && value <= most) return;
  throw std::invalid_argument(fmt::format("DefectOptions.{} = {}: must be 0 to {}", name, value, most));
}

Eigen::Vector3d vector_of(const Position& p) noexcept { return {p.x, p.y, p.z}; }

std::vector<std::vector<std::size_t>> nearest_few(const Eigen::Matrix3Xd& neutral_mm, std::size_t few) {
  const auto count = static_cast<std::size_t>(neutral_mm.cols());
  std::vector<std::vector<std::size_t>> nearest(count);
  for (std::size_t m = 0; m < count; ++m) {
    const auto squared_distance = [&](std::size_t other) {
      return (neutral_mm.col(static_cast<Eigen::Index>(m)) - neutral_mm.col(static_cast<Eigen::Index>(other)))
          .squaredNorm();
    };
    std::vector<std::size_t> others(count);
    std::iota(others.begin(), others.end(), 0u);
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(m));
    std::stable_sort(others.begin(), others.end(),
                     [&](std::size_t a, std::size_t b) { return squared_distance(a) < squared_distance(b); });
    others.resize(std::min(few, others.size()));
    nearest[m] = std::move(others);
  }
  return nearest;
}

}  // namespace

MarkerDefects::MarkerDefects(const Eigen::Matrix3Xd& neutral_mm, double rate_hz, const DefectOptions& options,
                             std::uint64_t seed)
    : options_(options),
      rate_hz_(rate_hz),
      seed_(seed),
      neighbours_(nearest_few(neutral_mm, kNeighbours)),
      tracks_(neighbours_.size()),
      occlusions_(seed, 11),
      false_tracks_(seed, 12),
      noise_(seed, 13) {
  require(options.noise_mm, "noise_mm", 10);
  require(options.occlusion_share, "occlusion_share", 0.5);
  require(options.false_track_share, "false_track_share", 0.2);
  const double mean_gap_frames = std::max(1.0, rate_hz * mean_gap_s());
  if (options.occlusion_share > 0)
    mean_visible_frames_ = mean_gap_frames * (1 - options.occlusion_share) / options.occlusion_share;
  const double spoiled = 2 - kJumpShare - kGhostShare;  // markers per event, on average
  // Of the visible samples the share f is to be false; events start only on those that are not.
  start_probability_ = options.false_track_share / (1 - options.false_track_share) / (kMeanFalseTrack * spoiled);
  rewind();
}

void MarkerDefects::rewind() {
  occlusions_ = Random(seed_, 11);
  false_tracks_ = Random(seed_, 12);
  noise_ = Random(seed_, 13);
  for (Track& track : tracks_) {
    track = Track{};
    if (options_.occlusion_share == 0) continue;
    track.occluded = occlusions_.chance(options_.occlusion_share);
    track.frames_to_change = track.occluded ? draw_gap_frames() : draw_visible_frames();
  }
}

std::int64_t MarkerDefects::draw_gap_frames() noexcept {
  const double gap_s = std::min(kLongestGapS, kGapMedianS * std::exp(kGapSigma * occlusions_.gaussian()));
  return std::max<std::int64_t>(1, std::llround(gap_s * rate_hz_));
}

std::int64_t MarkerDefects::draw_visible_frames() noexcept {
  return std::max<std::int64_t>(1, std::llround(occlusions_.exponential(mean_visible_frames_)));
}

Eigen::Vector3d MarkerDefects::draw_offset(double least_mm, double most_mm) noexcept {
  Eigen::Vector3d direction;
  for (double& coordinate : direction) coordinate = false_tracks_.gaussian();
  const double length = std::max(direction.norm(), 1e-9);
  return false_tracks_.uniform(least_mm, most_mm) / length * direction;
}

void MarkerDefects::step_occlusion(Track& track) noexcept {
  if (options_.occlusion_share == 0 || --track.frames_to_change > 0) return;
  track.occluded = !track.occluded;
  track.frames_to_change = track.occluded ? draw_gap_frames() : draw_visible_frames();
}

void MarkerDefects::start_false_track(std::size_t marker) noexcept {
  Track& track = tracks_[marker];
  const double kind = false_tracks_.uniform();
  const int frames = 1 + static_cast<int>(false_tracks_.index(kLongestFalseTrack));
  const std::vector<std::size_t>& nearest = neighbours_[marker];
  if (kind < kJumpShare || nearest.empty()) {
    track.reason = RejectReason::kJump;
    track.offset_mm = draw_offset(8, 40);
    track.false_frames = frames;
    return;
  }
  track.partner = nearest[false_tracks_.index(nearest.size())];
  if (kind < kJumpShare + kGhostShare) {
    track.reason = RejectReason::kGhost;
    track.offset_mm = draw_offset(0.5, 2);
    track.false_frames = frames;
    return;
  }
  Track& partner = tracks_[track.partner];
  if (partner.false_frames > 0 || partner.occluded) return;
  partner.reason = track.reason = RejectReason::kSwap;
  partner.partner = marker;
  partner.offset_mm = track.offset_mm = Eigen::Vector3d::Zero();
  partner.false_frames = track.false_frames = frames;
}

Position MarkerDefects::noisy(const Eigen::Vector3d& position_mm) noexcept {
  Eigen::Vector3d p = position_mm;
  if (options_.noise_mm > 0) {
    for (double& coordinate : p) coordinate += options_.noise_mm * noise_.gaussian();
  }
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

void MarkerDefects::apply(MarkerFrame& clean, MarkerFrame& observed) noexcept {
  for (Track& track : tracks_) step_occlusion(track);
  for (std::size_t m = 0; m < tracks_.size(); ++m) {
    const Track& track = tracks_[m];
    if (!track.occluded && track.false_frames == 0 && false_tracks_.chance(start_probability_)) start_false_track(m);
  }
  for (std::size_t m = 0; m < tracks_.size(); ++m) {
    const Track& track = tracks_[m];
    observed.state[m] = clean.state[m] = track.occluded ? MarkerState::kMissing : MarkerState::kMeasured;
    observed.reason[m] = clean.reason[m] = RejectReason::kNone;
    observed.position_mm[m] = Position{};
    if (track.occluded) continue;
    // A swap needs both markers; while one is occluded the other is itself again.
    const bool is_half_swap = track.reason == RejectReason::kSwap && tracks_[track.partner].occluded;
    const bool is_false = track.false_frames > 0 && !is_half_swap;
    const std::size_t source = is_false && track.reason != RejectReason::kJump ? track.partner : m;
    Eigen::Vector3d position_mm = vector_of(clean.position_mm[source]);
    if (is_false) {
      position_mm += track.offset_mm;
      clean.state[m] = MarkerState::kRejected;
      clean.reason[m] = track.reason;
    }
    observed.position_mm[m] = noisy(position_mm);
  }
  for (Track& track : tracks_) {
    if (track.false_frames > 0) --track.false_frames;
  }
}

}  // namespace risorius
