#include "synthetic_face.h"

#include <cmath>
#include <fmt/format.h>
#include <random>

namespace risorius::test {
namespace {

constexpr int kStabilisers = 6;
constexpr double kPi = 3.14159265358979323846;

Eigen::Vector3d on_face(double longitude, double latitude) {
  return {70 * std::sin(longitude) * std::cos(latitude), 95 * std::sin(latitude),
          80 * std::cos(longitude) * std::cos(latitude)};
}

}  // namespace

Rig synthetic_rig(int marker_count, int au_count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Rig rig;
  rig.name = "synthetic";
  rig.neutral_mm.resize(3, marker_count);
  rig.stabiliser_weight = Eigen::VectorXd::Zero(marker_count);
  for (int m = 0; m < marker_count; ++m) {
    rig.marker_names.push_back(fmt::format("M{}", m));
    if (m < kStabilisers) {
      rig.stabiliser_weight[m] = 1;
      rig.neutral_mm.col(m) = on_face(0.4 * (m - 2.5), 0.9 + 0.25 * (m % 2));
    } else {
      rig.neutral_mm.col(m) = on_face(1.2 * uniform(random), -0.3 + 0.9 * uniform(random));
    }
  }
  for (int i = 0; i < au_count; ++i) {
    const Eigen::Vector3d centre = on_face(1.1 * uniform(random), -0.3 + 0.8 * uniform(random));
    const Eigen::Vector3d direction =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized() * (8 + 4 * uniform(random));
    RigAu au;
    au.name = fmt::format("AU{}{}", i / 2 + 1, i % 2 == 0 ? "L" : "R");
    au.displacement_mm = Eigen::Matrix3Xd::Zero(3, marker_count);
    for (int m = kStabilisers; m < marker_count; ++m) {
      const double distance = (rig.neutral_mm.col(m) - centre).norm();
      au.displacement_mm.col(m) = direction * std::exp(-distance * distance / (2 * 25.0 * 25.0));
    }
    rig.aus.push_back(au);
  }
  return rig;
}

MarkerSet marker_set_of(const Rig& rig) {
  MarkerSet set;
  set.id = 7;
  set.names = rig.marker_names;
  set.rate_hz = 60;
  return set;
}

MarkerFrame marker_frame(const Rig& rig, const Eigen::VectorXd& x, const RigidTransform& world_from_head,
                         std::uint64_t sequence) {
  MarkerFrame frame;
  frame.header.set_id = marker_set_of(rig).id;
  frame.header.sequence = sequence;
  frame.header.capture_time_ns = static_cast<std::int64_t>(sequence) * 1'000'000'000 / 60;
  frame.count = static_cast<std::uint32_t>(rig.marker_count());
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    Eigen::Vector3d p = rig.neutral_mm.col(column);
    for (std::size_t i = 0; i < rig.au_count(); ++i) {
      p += x[static_cast<Eigen::Index>(i)] * rig.aus[i].displacement_mm.col(column);
    }
    const Eigen::Vector3f world = (world_from_head * p).cast<float>();
    frame.position_mm[m] = {world.x(), world.y(), world.z()};
    frame.state[m] = MarkerState::kMeasured;
  }
  return frame;
}

void add_noise(MarkerFrame& frame, double standard_deviation_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, standard_deviation_mm);
  for (std::size_t m = 0; m < frame.count; ++m) {
    Position& p = frame.position_mm[m];
    for (float* axis : {&p.x, &p.y, &p.z}) *axis = static_cast<float>(*axis + normal(random));
  }
}

Eigen::VectorXd smooth_intensities(int au_count, double time_s, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Eigen::VectorXd x(au_count);
  for (int i = 0; i < au_count; ++i) {
    const double hertz = 0.2 + uniform(random), phase = 2 * kPi * uniform(random);
    x[i] = std::max(0.0, std::sin(2 * kPi * hertz * time_s + phase));
  }
  return x;
}

}  // namespace risorius::test
