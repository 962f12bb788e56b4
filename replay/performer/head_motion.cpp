#include "replay/performer/head_motion.h"

#include <Eigen/Geometry>
#include <cmath>

#include "replay/performer/random.h"

namespace risorius {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSlowestHz = 0.05, kFastestHz = 2.5;
constexpr double kColour = 1.0;  // amplitude ~ 1 / frequency^kColour
constexpr std::array<double, 6> kLimit{8, 5, 8, 5 * kPi / 180, 5 * kPi / 180, 3 * kPi / 180};
const Eigen::Vector3d kSeatedHeadMm(20, 1200, -30);  // where the head is in the room

}  // namespace

HeadMotion::HeadMotion(double strength, std::uint64_t seed) {
  Random random(seed, 4);
  const double step = std::pow(kFastestHz / kSlowestHz, 1.0 / (kWaves - 1));
  for (std::size_t c = 0; c < waves_.size(); ++c) {
    double sum = 0, hz = kSlowestHz;
    for (Wave& wave : waves_[c]) {
      const double frequency_hz = hz * random.uniform(0.85, 1.15);
      wave = {std::pow(frequency_hz, -kColour), 2 * kPi * frequency_hz, random.uniform(0, 2 * kPi)};
      sum += wave.amplitude;
      hz *= step;
    }
    for (Wave& wave : waves_[c]) wave.amplitude *= strength * kLimit[c] / sum;
  }
}

Pose HeadMotion::at(double time_s) const noexcept {
  std::array<double, 6> x{};
  for (std::size_t c = 0; c < x.size(); ++c) {
    for (const Wave& wave : waves_[c]) x[c] += wave.amplitude * std::sin(wave.radians_per_s * time_s + wave.phase);
  }
  const Eigen::Vector3d turn(x[3], x[4], x[5]);
  const double angle = turn.norm();
  const Eigen::Quaterniond rotation =
      angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) : Eigen::Quaterniond::Identity();
  const Eigen::Vector3d translation = kSeatedHeadMm + Eigen::Vector3d(x[0], x[1], x[2]);
  return {{rotation.x(), rotation.y(), rotation.z(), rotation.w()},
          {translation.x(), translation.y(), translation.z()}};
}

}  // namespace risorius
