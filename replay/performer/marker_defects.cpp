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
constexpr double kRegionRadiusMm = 40, kRegionMedianS = 0.5, kRegionSigma = 0.5, kLongestRegionS = 3;
constexpr double kColourTimeS = 0.25;
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
      neutral_mm_(neutral_mm),
      noise_keep_(std::exp(-1 / (rate_hz * kColourTimeS))),
      coloured_mm_(Eigen::Matrix3Xd::Zero(3, neutral_mm.cols())),
      causes_(neighbours_.size(), DefectCause::kGood),
      is_absent_(neighbours_.size(), 0),
      occlusions_(seed, 11),
      false_tracks_(seed, 12),
      noise_(seed, 13),
      regions_(seed, 14),
      coloured_(seed, 15) {
  require(options.noise_mm, "noise_mm", 10);
  require(options.occlusion_share, "occlusion_share", 0.5);
  require(options.false_track_share, "false_track_share", 0.2);
  require(options.coloured_noise_mm, "coloured_noise_mm", 10);
  require(options.regions_per_minute, "regions_per_minute", 60);
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
  regions_ = Random(seed_, 14);
  coloured_ = Random(seed_, 15);
  region_frames_ = 0;
  for (double& value : coloured_mm_.reshaped()) value = options_.coloured_noise_mm * coloured_.gaussian();
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

void MarkerDefects::step_region() noexcept {
  if (options_.regions_per_minute == 0) return;
  if (region_frames_ > 0) {
    --region_frames_;
  } else if (regions_.chance(options_.regions_per_minute / (60 * rate_hz_))) {
    region_centre_ = regions_.index(tracks_.size());
    const double seconds = std::min(kLongestRegionS, kRegionMedianS * std::exp(kRegionSigma * regions_.gaussian()));
    region_frames_ = std::max<std::int64_t>(1, std::llround(seconds * rate_hz_));
  }
}

bool MarkerDefects::is_covered(std::size_t marker) const noexcept {
  const auto distance_mm = [&] {
    return (neutral_mm_.col(static_cast<Eigen::Index>(marker)) -
            neutral_mm_.col(static_cast<Eigen::Index>(region_centre_)))
        .norm();
  };
  return region_frames_ > 0 && distance_mm() <= kRegionRadiusMm;
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
  if (partner.false_frames > 0 || is_hidden(track.partner)) return;
  partner.reason = track.reason = RejectReason::kSwap;
  partner.partner = marker;
  partner.offset_mm = track.offset_mm = Eigen::Vector3d::Zero();
  partner.false_frames = track.false_frames = frames;
}

Position MarkerDefects::noisy(std::size_t marker, const Eigen::Vector3d& position_mm) noexcept {
  Eigen::Vector3d p = position_mm;
  if (options_.noise_mm > 0) {
    for (double& coordinate : p) coordinate += options_.noise_mm * noise_.noise();
  }
  if (options_.coloured_noise_mm > 0) p += coloured_mm_.col(static_cast<Eigen::Index>(marker));
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

void MarkerDefects::apply(MarkerFrame& clean, MarkerFrame& observed) noexcept {
  for (std::size_t m = 0; m < tracks_.size(); ++m) is_absent_[m] = clean.state[m] == MarkerState::kMissing;
  for (Track& track : tracks_) step_occlusion(track);
  step_region();
  if (options_.coloured_noise_mm > 0) {
    const double input = options_.coloured_noise_mm * std::sqrt(1 - noise_keep_ * noise_keep_);
    for (double& value : coloured_mm_.reshaped()) value = noise_keep_ * value + input * coloured_.noise();
  }
  for (std::size_t m = 0; m < tracks_.size(); ++m) {
    const bool can_start = !is_hidden(m) && tracks_[m].false_frames == 0;
    if (can_start && false_tracks_.chance(start_probability_)) start_false_track(m);
  }
  for (std::size_t m = 0; m < tracks_.size(); ++m) {
    const Track& track = tracks_[m];
    const bool hidden = is_hidden(m);
    observed.state[m] = clean.state[m] = hidden ? MarkerState::kMissing : MarkerState::kMeasured;
    observed.reason[m] = clean.reason[m] = RejectReason::kNone;
    observed.position_mm[m] = Position{};
    causes_[m] = !hidden ? DefectCause::kGood : track.occluded ? DefectCause::kOccluded : DefectCause::kRegionOccluded;
    if (is_absent_[m] != 0) causes_[m] = DefectCause::kAbsent;
    if (hidden) continue;
    // A swap needs both markers; while one is occluded the other is itself again.
    const bool is_half_swap = track.reason == RejectReason::kSwap && is_hidden(track.partner);
    // Nobody knows where an absent partner is.
    const bool has_no_partner = track.reason != RejectReason::kJump && is_absent_[track.partner] != 0;
    const bool is_false = track.false_frames > 0 && !is_half_swap && !has_no_partner;
    const std::size_t source = is_false && track.reason != RejectReason::kJump ? track.partner : m;
    Eigen::Vector3d position_mm = vector_of(clean.position_mm[source]);
    if (is_false) {
      position_mm += track.offset_mm;
      clean.state[m] = MarkerState::kRejected;
      clean.reason[m] = track.reason;
      causes_[m] = track.reason == RejectReason::kJump    ? DefectCause::kJump
                   : track.reason == RejectReason::kGhost ? DefectCause::kGhost
                                                          : DefectCause::kSwap;
    }
    observed.position_mm[m] = noisy(m, position_mm);
  }
  for (Track& track : tracks_) {
    if (track.false_frames > 0) --track.false_frames;
  }
}

}  // namespace risorius
