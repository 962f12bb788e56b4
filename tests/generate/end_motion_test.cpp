#include "generate/end_motion.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

constexpr double kRate_hz = 120;

/// 20 rows of value(t), t = 0 at the last one.
template <class Value>
AuMatrix past_of(Value value, double rate_hz = kRate_hz) {
  AuMatrix past(20, 1);
  for (Eigen::Index row = 0; row < 20; ++row)
    past(row, 0) = static_cast<float>(value(static_cast<double>(row - 19) / rate_hz));
  return past;
}

TEST(EndMotion, OfACubicIsTheCubics) {
  for (const double rate_hz : {60.0, 120.0, 240.0}) {
    const EndMotion motion =
        end_motion(past_of([](double t) { return 0.4 + t * (0.5 + t * (-1.5 + t * 4)); }, rate_hz), 0, rate_hz);
    EXPECT_NEAR(motion.velocity_per_s, 0.5, 1e-3) << rate_hz;
    EXPECT_NEAR(motion.acceleration_per_s2, -3, 0.1) << rate_hz;
    EXPECT_NEAR(motion.jerk_per_s3, 24, 24 * 0.3) << rate_hz << ": of single-precision rows";
  }
}

TEST(EndMotion, ForetellsTheNextRowOfASmoothPastBetterThanAParabola) {
  const auto value = [](double t) { return 0.3 + 0.1 * std::sin(14 * t + 1); };
  const EndMotion motion = end_motion(past_of(value), 0, kRate_hz);
  const double t = 1 / kRate_hz;
  const double told =
      value(0) + t * (motion.velocity_per_s + t / 2 * (motion.acceleration_per_s2 + t / 3 * motion.jerk_per_s3));
  const double parabola = 3 * value(0) - 3 * value(-t) + value(-2 * t);
  EXPECT_LT(std::abs(told - value(t)), 0.3 * std::abs(parabola - value(t)));
}

TEST(EndMotion, OfANoisyRestIsSmall) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.004);
  double squares = 0;
  constexpr int kFaces = 200;
  for (int face = 0; face < kFaces; ++face)
    squares +=
        std::pow(end_motion(past_of([&](double) { return 0.3 + noise(random); }), 0, kRate_hz).velocity_per_s, 2);
  // By the cubic through four rows alone it would be 0.004 * 120 * sqrt(3.4 + 9 + 2.25 + 0.1) = 1.8 per second.
  EXPECT_LT(std::sqrt(squares / kFaces), 0.75);
}

TEST(EndMotion, OfAShortPastIsWhatItCanTell) {
  const AuMatrix past = past_of([](double t) { return 0.4 + 0.5 * t; });
  EXPECT_EQ(end_motion(past.bottomRows(1), 0, kRate_hz).velocity_per_s, 0);
  for (const Eigen::Index rows : {2, 3, 4, 5, 8}) {
    const EndMotion motion = end_motion(past.bottomRows(rows), 0, kRate_hz);
    EXPECT_NEAR(motion.velocity_per_s, 0.5, 2e-3) << rows;
    EXPECT_NEAR(motion.acceleration_per_s2, 0, 0.5) << rows;
  }
}

}  // namespace
}  // namespace risorius
