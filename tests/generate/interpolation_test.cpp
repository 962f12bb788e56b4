#include "generate/interpolation.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

using Eigen::Index;

constexpr double kRate_hz = 120;
constexpr float kRounding = 2e-6F;  // some units in the last place of a float near 1

/// A past of `rows` frames of one AU that runs along x + v t + a t^2 / 2 and ends at t = 0.
TransitionRequest request_of(double x, double v, double a, double target, Index frames = 60, Index rows = 12) {
  TransitionRequest request{.past = AuMatrix(rows, 1), .target = {}, .frames = frames, .rate_hz = kRate_hz};
  for (Index row = 0; row < rows; ++row) {
    const double t = static_cast<double>(row - rows + 1) / kRate_hz;
    request.past(row, 0) = static_cast<float>(x + v * t + a * t * t / 2);
  }
  request.target = Eigen::VectorXf::Constant(1, static_cast<float>(target));
  return request;
}

AuMatrix generated(std::string_view name, const TransitionRequest& request) {
  AuMatrix result;
  make_interpolation(name)->generate(request, result);
  return result;
}

TEST(Interpolation, EveryKindEndsOnItsTargetAndStaysInBounds) {
  for (const InterpolationKind kind : kInterpolationKinds) {
    Interpolation model(kind);
    for (const double target : {0.0, 0.4, 1.2}) {
      for (const double velocity : {-6.0, 0.0, 6.0}) {  // as fast as a blink
        for (const Index frames : {1, 2, 41, 402}) {
          AuMatrix result;
          model.generate(request_of(0.5, velocity, 0, target, frames), result);
          ASSERT_EQ(result.rows(), frames);
          EXPECT_EQ(result(frames - 1, 0), static_cast<float>(target)) << model.name();
          EXPECT_GE(result.minCoeff(), 0) << model.name();
          EXPECT_LE(result.maxCoeff(), 1.2F) << model.name();
        }
      }
    }
  }
}

TEST(Interpolation, HoldStaysUntilItsLastFrame) {
  const AuMatrix result = generated("hold", request_of(0.3, 2, 0, 0.9));
  for (Index k = 0; k + 1 < result.rows(); ++k) EXPECT_EQ(result(k, 0), 0.3F);
}

TEST(Interpolation, LinearGoesEqualSteps) {
  const AuMatrix result = generated("linear", request_of(0.2, 0, 0, 0.8));
  for (Index k = 0; k < result.rows(); ++k)
    EXPECT_NEAR(result(k, 0), 0.2 + 0.6 * static_cast<double>(k + 1) / 60, kRounding);
}

TEST(Interpolation, MinimumJerkIsHalfwayAtHalfTimeAndFastestThere) {
  const AuMatrix result = generated("minimum_jerk", request_of(0.2, 3, 0, 0.8));
  EXPECT_NEAR(result(29, 0), 0.5, kRounding);
  // Its peak velocity is 15/8 of the mean one (Flash & Hogan 1985, eq. 3 differentiated); here over two frames.
  const double peak_per_s = (result(30, 0) - result(28, 0)) / 2 * kRate_hz;
  EXPECT_NEAR(peak_per_s, 15.0 / 8 * 0.6 / 0.5, 0.003);
  for (Index k = 0; k < 59; ++k) EXPECT_NEAR(result(k, 0) + result(58 - k, 0), 1.0, 2 * kRounding) << "symmetric";
}

TEST(Interpolation, CubicHermiteIsTheCubicOfItsEnds) {
  // x(t) = 0.4 + 0.8 t - 3.2 t^2 + 3.2 t^3 has x'(0.5) = 0, x''(0) = -6.4: the past is its parabola.
  const auto cubic = [](double t) { return 0.4 + 0.8 * t - 3.2 * t * t + 3.2 * t * t * t; };
  const AuMatrix result = generated("cubic_hermite", request_of(0.4, 0.8, -6.4, cubic(0.5)));
  for (Index k = 0; k < result.rows(); ++k)
    EXPECT_NEAR(result(k, 0), cubic(static_cast<double>(k + 1) / kRate_hz), 20 * kRounding) << k;
}

TEST(Interpolation, QuinticHasTheStartsVelocityAndAccelerationAndNoneAtTheEnd) {
  const double v = 0.6, a = -2;
  const AuMatrix result = generated("quintic", request_of(0.4, v, a, 0.9, 240));
  const auto x = [&](Index k) { return k < 0 ? 0.4 : static_cast<double>(result(k, 0)); };
  // Taylor's remainder after three frames of a jerk of at most 60 (x1 - x0) / T^3 + ... < 10 per s^3.
  for (Index k = 0; k < 3; ++k) {
    const double t = static_cast<double>(k + 1) / kRate_hz;
    EXPECT_NEAR(x(k), 0.4 + v * t + a * t * t / 2, 10 * t * t * t / 6 + 20 * kRounding);
  }
  EXPECT_NEAR(x(239), x(238), 1e-5);
  EXPECT_NEAR(x(239) - 2 * x(238) + x(237), 0, 1e-5);
}

TEST(Interpolation, MotionIsExactOnAParabolaAndAverageUnderNoise) {
  const TransitionRequest request = request_of(0.5, 1.5, 8, 0.5);
  const PastMotion motion = motion_at_end(request.past, kRate_hz, 50);
  EXPECT_NEAR(motion.velocity_per_s[0], 1.5, 1e-3);
  EXPECT_NEAR(motion.acceleration_per_s2[0], 8, 0.05);
  // A step of 0.01 back and forth is 2.4 per s from frame to frame; seven frames average most of it away.
  TransitionRequest noisy = request;
  for (Index row = 0; row < noisy.past.rows(); row += 2) noisy.past(row, 0) += 0.01F;
  EXPECT_NEAR(motion_at_end(noisy.past, kRate_hz, 50).velocity_per_s[0], 1.5, 0.6);
}

TEST(Interpolation, OneFrameOfPastHasNoMotionAndTwoHaveALine) {
  EXPECT_EQ(motion_at_end(request_of(0.5, 1, 0, 0, 1, 1).past, kRate_hz, 50).velocity_per_s[0], 0);
  const PastMotion line = motion_at_end(request_of(0.5, 1, 0, 0, 1, 2).past, kRate_hz, 50);
  EXPECT_NEAR(line.velocity_per_s[0], 1, 1e-4);
  EXPECT_EQ(line.acceleration_per_s2[0], 0);
}

TEST(Interpolation, SameRequestTwiceGivesTheSameBits) {
  for (const InterpolationKind kind : kInterpolationKinds) {
    Interpolation model(kind);
    AuMatrix first, second;
    model.generate(request_of(0.1, 0.5, 1, 0.7, 99), first);
    model.generate(request_of(0.1, 0.5, 1, 0.7, 99), second);
    EXPECT_EQ(std::memcmp(first.data(), second.data(), sizeof(float) * 99), 0);
  }
}

TEST(Interpolation, RefusesRequestsThatDoNotFit) {
  const TransitionRequest good = request_of(0.1, 0, 0, 0.5);
  const auto refused = [&](auto spoil) {
    TransitionRequest bad = good;
    spoil(bad);
    AuMatrix result;
    Interpolation model(InterpolationKind::kLinear);
    EXPECT_THROW(model.generate(bad, result), std::invalid_argument);
  };
  refused([](auto& r) { r.past.resize(0, 1); });
  refused([](auto& r) { r.target = Eigen::VectorXf::Zero(2); });
  refused([](auto& r) { r.frames = 0; });
  refused([](auto& r) { r.rate_hz = 0; });
  refused([](auto& r) { r.rate_hz = std::numeric_limits<double>::infinity(); });
  refused([](auto& r) { r.past(3, 0) = std::numeric_limits<float>::quiet_NaN(); });
  refused([](auto& r) { r.target[0] = std::numeric_limits<float>::infinity(); });
  EXPECT_THROW(Interpolation(InterpolationKind::kLinear, {.window_ms = -1}), std::invalid_argument);
  EXPECT_EQ(make_interpolation("spline"), nullptr);
}

}  // namespace
}  // namespace risorius
