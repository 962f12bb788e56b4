#include "capture/repair/measurement_noise.h"

#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

constexpr double kStepS = 1.0 / 120;

/// The deviation found after 10 s of a track that swings and trembles.
double found_mm(double noise_mm, double swing_mm) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, noise_mm);
  MeasurementNoise noise;
  noise.resize(1);
  std::vector<Eigen::Vector3d> position(1);
  for (int f = 0; f < 1200; ++f) {
    const double t = f * kStepS;
    // Moves for a third of the time, as faces do.
    const double swing = std::fmod(t, 3) < 1 ? swing_mm * std::sin(6.28 * t) : 0;
    position[0] = Eigen::Vector3d(normal(random) + swing, normal(random), normal(random) - swing);
    noise.observe(position, {1}, kStepS);
  }
  return std::sqrt(noise.variance_mm2(0));
}

TEST(MeasurementNoise, FindsWhiteNoise) {
  for (const double sigma : {0.01, 0.1, 1.0}) EXPECT_NEAR(found_mm(sigma, 0) / sigma, 1, 0.1) << sigma;
}

TEST(MeasurementNoise, IsHardlyTouchedByMotionThatComesAndGoes) { EXPECT_NEAR(found_mm(0.1, 10) / 0.1, 1, 0.3); }

TEST(MeasurementNoise, IsUnknownAtFirstAndAfterReset) {
  MeasurementNoise noise;
  noise.resize(2);
  EXPECT_EQ(noise.variance_mm2(0), 0);
  for (int f = 0; f < 100; ++f) noise.observe({{0.1 * (f % 2), 0, 0}, {0, 0, 0}}, {1, 0}, kStepS);
  EXPECT_GT(noise.variance_mm2(0), 0);
  EXPECT_EQ(noise.variance_mm2(1), 0);  // never measured
  noise.reset();
  EXPECT_EQ(noise.variance_mm2(0), 0);
}

}  // namespace
}  // namespace risorius
