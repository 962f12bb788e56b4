#include "replay/performer/performer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <stdexcept>
#include <utility>

namespace risorius {
namespace {

constexpr std::uint32_t kSetId = 1;

void require(double value, const char* name, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("PerformerOptions.{} = {}: must be {} to {}", name, value, least, most));
}

const PerformerOptions& checked(const PerformerOptions& options) {
  require(options.rate_hz, "rate_hz", 1, 2000);
  require(options.seconds, "seconds", 0, 86400);
  require(options.head_motion, "head_motion", 0, 3);
  require(options.micro_motion, "micro_motion", 0, 3);
  require(options.amplitude, "amplitude", 0.1, 4);
  return options;
}

Rig checked(Rig rig) {
  const auto refuse = [&](const std::string& problem) {
    throw std::invalid_argument(fmt::format("Performance: rig '{}' {}", rig.name, problem));
  };
  if (rig.marker_count() < 1 || rig.marker_count() > kMaxMarkers)
    refuse(fmt::format("has {} markers, not 1 to {}", rig.marker_count(), kMaxMarkers));
  if (rig.au_count() < 1 || rig.au_count() > kMaxAus)
    refuse(fmt::format("has {} AUs, not 1 to {}", rig.au_count(), kMaxAus));
  const auto markers = static_cast<Eigen::Index>(rig.marker_count());
  if (rig.neutral_mm.cols() != markers || !rig.neutral_mm.allFinite())
    refuse("has not one finite neutral position per marker");
  for (const RigAu& au : rig.aus) {
    if (au.displacement_mm.cols() != markers || !au.displacement_mm.allFinite())
      refuse("has a shape that does not fit: " + au.name);
  }
  return rig;
}

PerformerScript script_of(const Rig& rig, const PerformerOptions& options) {
  return PerformerScript(checked(rig).au_names(), {options.script, checked(options).seconds, options.seed,
                                                   options.co_activation, true, options.amplitude});
}

std::vector<double> bounds_of(const Rig& rig) {
  std::vector<double> upper;
  for (const RigAu& au : rig.aus) upper.push_back(au.upper_bound);
  return upper;
}

DefectOptions defects_of(const PerformerOptions& options) {
  return {options.noise_mm, options.occlusion_share, options.false_track_share, options.coloured_noise_mm,
          options.regions_per_minute};
}

/// Nearest nanosecond. In extended precision: a day at 120 Hz has more digits than a double's product keeps.
std::int64_t nanoseconds_of(std::uint64_t index, double rate_hz) noexcept {
  return std::llround(1e9L * static_cast<long double>(index) / static_cast<long double>(rate_hz));
}

Position rounded(const Eigen::Vector3d& p) noexcept {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

}  // namespace

Performance::Performance(Rig rig, const PerformerOptions& options)
    : Performance(rig, std::nullopt, script_of(rig, options), options) {}

Performance::Performance(Rig rig, AuTimeline series, const PerformerOptions& options)
    : Performance(std::move(rig), std::optional(std::move(series)), std::nullopt, options) {}

Performance::Performance(Rig rig, std::optional<AuTimeline> series, std::optional<PerformerScript> script,
                         const PerformerOptions& options)
    : rig_(checked(std::move(rig))),
      options_(checked(options)),
      series_(std::move(series)),
      script_(std::move(script)),
      upper_(bounds_of(rig_)),
      wander_(rig_.au_count(), shipped_dynamics().micro_motion, shipped_dynamics().rest_drift,
              series_ ? 0 : options.micro_motion, options.rate_hz, options.seed),
      head_(options.head_motion, options.seed),
      model_(rig_, options.perturb, options.rate_hz, options.seed),
      defects_(model_.rig().neutral_mm, options.rate_hz, defects_of(options), options.seed),
      head_mm_(rig_.neutral_mm) {
  if (options_.seconds == 0)
    options_.seconds = series_ ? series_->seconds() + 1 / options_.rate_hz : script_->seconds();
  frame_count_ = static_cast<std::uint64_t>(std::ceil(options_.seconds * options_.rate_hz - 1e-9));
}

bool Performance::next(MarkerFrame& observed, AuFrame& truth, MarkerFrame& clean) noexcept {
  if (next_index_ >= frame_count_) return false;
  const double time_s = static_cast<double>(next_index_) / options_.rate_hz;
  FrameHeader header;
  header.set_id = kSetId;
  header.sequence = next_index_;
  header.capture_time_ns = nanoseconds_of(next_index_, options_.rate_hz);
  ++next_index_;

  truth = AuFrame{};
  truth.header = header;
  truth.count = static_cast<std::uint32_t>(rig_.au_count());
  truth.status = SolverStatus::kConverged;
  truth.world_from_head = head_.at(time_s);
  const std::span<double> intensities = std::span(truth.intensity).first(rig_.au_count());
  if (series_) {
    series_->at(time_s, intensities);
  } else {
    script_->intensities_at(time_s, intensities);
  }
  for (std::size_t k = 0; k < intensities.size(); ++k) intensities[k] = std::clamp(intensities[k], 0.0, upper_[k]);
  wander_.add_to(intensities, upper_);
  for (std::size_t k = 0; k < rig_.au_count(); ++k) truth.state[k] = AuState::kObserved;

  clean = MarkerFrame{};
  clean.header = header;
  clean.count = static_cast<std::uint32_t>(rig_.marker_count());
  observed = clean;
  const Pose& pose = truth.world_from_head;
  const Eigen::Quaterniond rotation(pose.rotation_xyzw[3], pose.rotation_xyzw[0], pose.rotation_xyzw[1],
                                    pose.rotation_xyzw[2]);
  const Eigen::Vector3d translation(pose.translation_mm[0], pose.translation_mm[1], pose.translation_mm[2]);
  model_.pose_next(intensities, head_mm_);
  for (std::size_t m = 0; m < rig_.marker_count(); ++m) {
    clean.state[m] = MarkerState::kMeasured;
    clean.position_mm[m] = rounded(rotation * head_mm_.col(static_cast<Eigen::Index>(m)) + translation);
  }
  defects_.apply(clean, observed);
  return true;
}

void Performance::rewind() {
  next_index_ = 0;
  if (script_) script_->rewind();
  wander_.rewind();
  model_.rewind();
  defects_.rewind();
}

MarkerSet Performance::marker_set() const {
  MarkerSet set;
  set.id = kSetId;
  set.names = rig_.marker_names;
  set.rate_hz = options_.rate_hz;
  return set;
}

PerformerTake::PerformerTake(Rig rig, const PerformerOptions& options)
    : PerformerTake(Performance(std::move(rig), options)) {}

PerformerTake::PerformerTake(Performance performance) : performance_(std::move(performance)) {
  info_.path = "builtin";
  info_.markers = performance_.marker_set();
  info_.frame_count = performance_.frame_count();
}

}  // namespace risorius
