#include "generate/transition_features.h"

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
