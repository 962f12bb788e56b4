#include "replay/performer/performer.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <stdexcept>
#include <utility>

namespace risorius {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint32_t kSetId = 1;
constexpr double kSwayMm = 8, kSwayUpMm = 5;
constexpr double kPitchDegrees = 5, kYawDegrees = 5, kRollDegrees = 3;
const Eigen::Vector3d kSeatedHeadMm(20, 1200, -30);  // where the head is in the room
constexpr std::array kSwayShares{0.5, 0.3, 0.2};
constexpr double kSlowestHz = 0.07, kFastestHz = 0.45;

void require(double value, const char* name, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("PerformerOptions.{} = {}: must be {} to {}", name, value, least, most));
}

const PerformerOptions& checked(const PerformerOptions& options) {
  require(options.rate_hz, "rate_hz", 1, 2000);
  require(options.seconds, "seconds", 1e-3, 86400);
  require(options.head_motion, "head_motion", 0, 3);
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

std::vector<std::string> names_of(const Rig& rig) {
  std::vector<std::string> names;
  for (const RigAu& au : rig.aus) names.push_back(au.name);
  return names;
}

/// Nearest nanosecond. In extended precision: a day at 120 Hz has more digits than a double's product keeps.
std::int64_t nanoseconds_of(std::uint64_t index, double rate_hz) noexcept {
  return std::llround(1e9L * static_cast<long double>(index) / static_cast<long double>(rate_hz));
}

Position rounded(const Eigen::Vector3d& p) noexcept {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

}  // namespace

double Performance::Sway::at(double time_s) const noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < amplitude.size(); ++i) {
    sum += amplitude[i] * std::sin(2 * kPi * frequency_hz[i] * time_s + phase[i]);
  }
  return sum;
}

Performance::Performance(Rig rig, const PerformerOptions& options)
    : rig_(checked(std::move(rig))),
      head_mm_(rig_.neutral_mm),
      options_(checked(options)),
      frame_count_(static_cast<std::uint64_t>(std::ceil(options.seconds * options.rate_hz - 1e-9))),
      script_(names_of(rig_), options.seconds, options.seed),
      defects_(rig_.neutral_mm, options.rate_hz, {options.noise_mm, options.occlusion_share, options.false_track_share},
               options.seed) {
  constexpr double kRadians = kPi / 180;
  const std::array<double, 6> amplitude{
      kSwayMm, kSwayUpMm, kSwayMm, kPitchDegrees * kRadians, kYawDegrees * kRadians, kRollDegrees * kRadians};
  Random random(options.seed, 4);
  for (std::size_t c = 0; c < sway_.size(); ++c) {
    for (std::size_t i = 0; i < kSwayShares.size(); ++i) {
      sway_[c].amplitude[i] = options.head_motion * amplitude[c] * kSwayShares[i];
      sway_[c].frequency_hz[i] = random.uniform(kSlowestHz, kFastestHz);
      sway_[c].phase[i] = random.uniform(0, 2 * kPi);
    }
  }
}

Pose Performance::pose_at(double time_s) const noexcept {
  const Eigen::Vector3d turn(sway_[3].at(time_s), sway_[4].at(time_s), sway_[5].at(time_s));
  const double angle = turn.norm();
  const Eigen::Quaterniond rotation =
      angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) : Eigen::Quaterniond::Identity();
  const Eigen::Vector3d translation =
      kSeatedHeadMm + Eigen::Vector3d(sway_[0].at(time_s), sway_[1].at(time_s), sway_[2].at(time_s));
  return {{rotation.x(), rotation.y(), rotation.z(), rotation.w()},
          {translation.x(), translation.y(), translation.z()}};
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
  truth.world_from_head = pose_at(time_s);
  script_.intensities_at(time_s, std::span(truth.intensity).first(rig_.au_count()));
  for (std::size_t k = 0; k < rig_.au_count(); ++k) truth.state[k] = AuState::kObserved;

  clean = MarkerFrame{};
  clean.header = header;
  clean.count = static_cast<std::uint32_t>(rig_.marker_count());
  observed = clean;
  const Pose& pose = truth.world_from_head;
  const Eigen::Quaterniond rotation(pose.rotation_xyzw[3], pose.rotation_xyzw[0], pose.rotation_xyzw[1],
                                    pose.rotation_xyzw[2]);
  const Eigen::Vector3d translation(pose.translation_mm[0], pose.translation_mm[1], pose.translation_mm[2]);
  head_mm_ = rig_.neutral_mm;
  for (std::size_t k = 0; k < rig_.au_count(); ++k) {
    if (truth.intensity[k] != 0) head_mm_ += truth.intensity[k] * rig_.aus[k].displacement_mm;
  }
  for (std::size_t m = 0; m < rig_.marker_count(); ++m) {
    clean.position_mm[m] = rounded(rotation * head_mm_.col(static_cast<Eigen::Index>(m)) + translation);
  }
  defects_.apply(clean, observed);
  return true;
}

void Performance::rewind() {
  next_index_ = 0;
  script_.rewind();
  defects_.rewind();
}

MarkerSet Performance::marker_set() const {
  MarkerSet set;
  set.id = kSetId;
  set.names = rig_.marker_names;
  set.rate_hz = options_.rate_hz;
  return set;
}

PerformerTake::PerformerTake(Rig rig, const PerformerOptions& options) : performance_(std::move(rig), options) {
  info_.path = "builtin";
  info_.markers = performance_.marker_set();
  info_.frame_count = performance_.frame_count();
}

}  // namespace risorius
