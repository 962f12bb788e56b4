#include "generate/transition_features.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

constexpr double kRate_hz = 120;

/// One AU whose value at time t (s, 0 at the last frame) is `value(t)`, on its way to `target`.
template <class Value>
TransitionFeatures features_of(Value value, float target = 0.5F) {
  TransitionRequest request;
  request.rate_hz = kRate_hz;
  request.frames = 120;
  request.past.resize(20, 1);
  for (Eigen::Index row = 0; row < 20; ++row)
    request.past(row, 0) = static_cast<float>(value(static_cast<double>(row - 19) / kRate_hz));
  request.target.setConstant(1, target);
  TransitionFeatures features;
  TransitionFeatureMaker({"AU12L"}).make(request, features);
  return features;
}

TEST(TransitionFeatures, MotionIsThatOfThePastsEndWhereThePastIsSmooth) {
  // An onset: its acceleration changes within the longest window.
  const double rate = 12, amplitude = 0.01;
  const TransitionFeatures features =
      features_of([&](double t) { return 0.2 + amplitude * (std::sin(rate * t) + std::cos(rate * t)); });
  EXPECT_NEAR(features.velocity_per_s(0), amplitude * rate, 0.01 * amplitude * rate);
  // Taken by a parabola, so of a moment half a window before the end.
  EXPECT_NEAR(features.acceleration_per_s2(0), -amplitude * rate * rate, 0.15 * amplitude * rate * rate + 0.3);
}

TEST(TransitionFeatures, NoiseOfARestingFaceIsNotTakenForMotion) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.004);
  double squares = 0;
  constexpr int kFaces = 200;
  for (int face = 0; face < kFaces; ++face) {
    const TransitionFeatures features = features_of([&](double) { return 0.3 + noise(random); });
    squares += std::pow(features.velocity_per_s(0), 2);
  }
  // By the parabola through three frames alone it would be 0.004 * 120 * sqrt(6.5) = 1.2 per second.
  EXPECT_LT(std::sqrt(squares / kFaces), 0.75);
}

/// What the start's motion adds to the way.
float most_added(const TransitionFeatures& features, float seconds = 1) {
  Eigen::RowVectorXf row(1);
  float most = 0;
  for (float t = 0; t < seconds; t += 0.002F) {
    transition_base(features, t, seconds, row);
    most = std::max(most, std::abs(row(0) - features.start(0) - minimum_jerk(t / seconds) * features.change(0)));
  }
  return most;
}

TEST(TransitionFeatures, AFastLidGoesOnAtItsPaceButNotFar) {
  // 20 per second: a blink closes in 50 ms.
  const TransitionFeatures features = features_of([](double t) { return std::max(0.0, 0.6 + 20 * t); });
  EXPECT_NEAR(features.velocity_per_s(0), 20, 0.5);
  EXPECT_LT(most_added(features), 0.5 + 2 * 0.05) << "velocity, acceleration, jerk";
}

TEST(TransitionFeatures, WhatBrakesIsNotCutAsWhatDrivesIs) {
  // Stopped within 1/30 s; what it has covered till then, 0.17, is more than an acceleration may add.
  const double velocity = 10, braking = -300;
  const auto course = [&](double t) { return 0.8 + velocity * t + braking / 2 * t * t; };
  const TransitionFeatures brakes = features_of([&](double t) { return std::max(0.0, course(t)); });
  EXPECT_NEAR(brakes.acceleration_per_s2(0), braking, 0.02 * -braking);
  const TransitionFeatures drives = features_of([&](double t) { return 0.2 + velocity * t - braking / 2 * t * t; });
  EXPECT_LT(drives.acceleration_per_s2(0), 0.5 * -braking);
  EXPECT_LT(most_added(drives), 0.5 + 2 * 0.05);
}

TEST(TransitionFeatures, AShortPastGivesWhatItCan) {
  TransitionRequest request{.past = AuMatrix::Constant(2, 1, 0.2F), .target = Eigen::VectorXf::Constant(1, 0.6F)};
  request.past(1, 0) = 0.21F;
  request.frames = 60;
  request.rate_hz = kRate_hz;
  TransitionFeatures features;
  TransitionFeatureMaker({"AU12L"}).make(request, features);
  EXPECT_NEAR(features.velocity_per_s(0), 0.01 * kRate_hz, 1e-3);
  EXPECT_EQ(features.acceleration_per_s2(0), 0);
}

}  // namespace
}  // namespace risorius
