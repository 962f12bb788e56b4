#include "generate/transition_base.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace risorius {
namespace {

constexpr double kRate_hz = 120;

/// One AU whose value at time t (s, 0 at the last frame) is `value(t)`, on its way to `target`.
template <class Value>
TransitionBase base_of(Value value, float target = 0.5F, Eigen::Index frames = 120) {
  TransitionRequest request;
  request.rate_hz = kRate_hz;
  request.frames = frames;
  request.past.resize(20, 1);
  for (Eigen::Index row = 0; row < 20; ++row)
    request.past(row, 0) = static_cast<float>(value(static_cast<double>(row - 19) / kRate_hz));
  request.target.setConstant(1, target);
  TransitionBase base;
  make_transition_base(request, base);
  return base;
}

float value_at(const TransitionBase& base, float t_s, float seconds = 1) {
  Eigen::RowVectorXf row(1);
  transition_base_at(base, t_s, seconds, row);
  return row(0);
}

/// The farthest that the curve comes back after it had gone in direction `sign`, within `until_s`.
float farthest_back(const TransitionBase& base, float sign, float until_s) {
  float most = 0, back = 0;
  for (float t = 0; t <= until_s; t += 0.002F) {
    const float gone = sign * (value_at(base, t) - base.start(0));
    most = std::max(most, gone);
    back = std::max(back, most - gone);
  }
  return back;
}

TEST(TransitionBase, LeavesWithTheMotionOfThePastAndArrivesAtRest) {
  // x = 0.3 + 0.8 t - t^2: too slow to be cut.
  const TransitionBase base = base_of([](double t) { return 0.3 + 0.8 * t - t * t; }, 0.7F);
  constexpr float kStep = 0.001F;
  const float x0 = value_at(base, 0), x1 = value_at(base, kStep), x2 = value_at(base, 2 * kStep);
  EXPECT_NEAR(x0, 0.3F, 1e-6F);
  EXPECT_NEAR((x1 - x0) / kStep, 0.8F, 0.01F);
  EXPECT_NEAR((x2 - 2 * x1 + x0) / (kStep * kStep), -2, 0.5F);
  EXPECT_NEAR(value_at(base, 1), 0.7F, 1e-6F);
  EXPECT_NEAR((value_at(base, 1) - value_at(base, 0.99F)) / 0.01F, 0, 0.01F);
}

TEST(TransitionBase, MotionIsThatOfThePastsEndWhereThePastIsSmooth) {
  // An onset: its acceleration changes within the longest window.
  const double rate = 12, amplitude = 0.01;
  const TransitionBase base =
      base_of([&](double t) { return 0.2 + amplitude * (std::sin(rate * t) + std::cos(rate * t)); });
  EXPECT_NEAR(base.velocity_per_s(0), amplitude * rate, 0.01 * amplitude * rate);
  // Taken by a parabola, so of a moment half a window before the end.
  EXPECT_NEAR(base.acceleration_per_s2(0), -amplitude * rate * rate, 0.15 * amplitude * rate * rate + 0.3);
}

TEST(TransitionBase, ALidThatOpensAtTheStartDoesNotCloseAgain) {
  // In the middle of a blink's opening, 8 per second, on its way to an open eye.
  const auto opening = [](double t) { return 0.5 - 8 * t - 20 * t * t; };
  const TransitionBase base = base_of(opening, 0);
  ASSERT_LT(base.velocity_per_s(0), -7);
  EXPECT_LT(value_at(base, 0.2F), 0.1F) << "open after a fifth of a second";
  EXPECT_LT(farthest_back(base, -1, 1), 0.05F) << "it may pass the target by so much";
}

TEST(TransitionBase, AMovementThatStopsStaysWhereItStopped) {
  // A smile that has nearly come to rest, on to twice as much: it must not sink first.
  const TransitionBase base = base_of([](double t) { return 0.4 + 1.5 * t - 10 * t * t; }, 0.8F);
  ASSERT_LT(base.acceleration_per_s2(0), 0);
  EXPECT_LT(farthest_back(base, 1, 1), 0.01F);
}

/// w of the header.
double fade(double s) { return s >= 1 ? 0 : 1 - s * s * s * (10 - s * (15 - 6 * s)); }

/// p of the header, by Simpson's rule.
double integrated(const TransitionBase& base, double t_s) {
  constexpr int kSteps = 2000;
  const auto slope = [&](double t) {
    return base.velocity_per_s(0) * fade(t / base.velocity_fade_s(0)) +
           base.acceleration_per_s2(0) * t * fade(t / base.acceleration_fade_s(0)) +
           base.jerk_per_s3(0) * t * t / 2 * fade(t / base.jerk_fade_s(0));
  };
  double sum = slope(0) + slope(t_s);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 1 ? 4 : 2) * slope(t_s * i / kSteps);
  return sum * t_s / kSteps / 3;
}

TEST(TransitionBase, IsWhatItsHeaderSays) {
  const auto cubic = [](double t) { return 0.4 + t * (0.5 + t * (-1.5 + t * 4)); };
  const auto sine = [](double t) { return 0.5 + 0.2 * std::sin(11 * t + 0.7); };
  for (const TransitionBase& base : {base_of(cubic), base_of(sine), base_of([](double t) { return 0.3 + 9 * t; })}) {
    EXPECT_NEAR(base.covered(0), integrated(base, 1), 1e-4);
    for (const float t : {0.004F, 0.02F, 0.07F, 0.2F, 0.5F, 0.9F}) {
      const double m = minimum_jerk(t);
      EXPECT_NEAR(value_at(base, t), base.start(0) + integrated(base, t) + m * (base.change(0) - integrated(base, 1)),
                  1e-4)
          << t;
    }
  }
  EXPECT_GT(base_of(cubic).jerk_per_s3(0), 10) << "the third derivative is taken, too";
}

TEST(TransitionBase, AFastLidGoesOnAtItsPaceButTurnsSoon) {
  // 20 per second: a blink closes in 50 ms. No movement is stopped in less than 1/30 s, in which it covers 20 / 60.
  const TransitionBase base = base_of([](double t) { return std::max(0.0, 0.6 + 20 * t); }, 0.2F);
  EXPECT_NEAR(base.velocity_per_s(0), 20, 0.5);
  EXPECT_NEAR(value_at(base, 0.005F) - base.start(0), 0.1F, 0.01F);
  EXPECT_NEAR(base.covered(0), 20.0F / 60, 0.06F);
}

TEST(TransitionBase, HowFarAStartGoesOnDependsOnWhereItIsToGo) {
  const auto covered = [](float start, float velocity, float target) {
    return base_of([=](double t) { return start + velocity * t; }, target).covered(0);
  };
  EXPECT_NEAR(covered(0.2F, 1, 0.9F), 0.125F, 0.01F) << "a quarter of a second, fading";
  EXPECT_NEAR(covered(0.2F, 4, 0.4F), 0.25F, 0.01F) << "a little beyond the target";
  EXPECT_NEAR(covered(0.3F, 10, 1.1F), 0.5F, 0.01F) << "half of the range at most";
  EXPECT_NEAR(covered(0.5F, 1, 0.2F), 0.075F, 0.01F) << "away from the target sooner";
  EXPECT_NEAR(covered(0.5F, 6, 0.2F), 0.2F, 0.01F) << "and less far";
  EXPECT_NEAR(covered(0.1F, -4, 0), -0.1F, 0.01F) << "not beyond a bound";
  EXPECT_NEAR(covered(1.1F, 4, 1.2F), 0.1F, 0.01F) << "nor the other";
}

TEST(TransitionBase, ArrivesAtRestHoweverShortTheWay) {
  for (const Eigen::Index frames : {3, 6, 12, 60}) {
    const TransitionBase base = base_of([](double t) { return 0.3 + 3 * t; }, 0.6F, frames);
    const float seconds = static_cast<float>(frames) / 120, step = 0.01F * seconds;
    EXPECT_NEAR(value_at(base, seconds, seconds), 0.6F, 1e-5F) << frames;
    EXPECT_NEAR((0.6F - value_at(base, seconds - step, seconds)) / step, 0, 0.05F) << frames;
  }
}

TEST(TransitionBase, WhatBrakesIsNotCutAsWhatDrivesIs) {
  // Stopped within 1/30 s; what it has covered till then, 0.17, is more than an acceleration may add.
  const double velocity = 10, braking = -300;
  const auto course = [&](double t) { return 0.8 + velocity * t + braking / 2 * t * t; };
  const TransitionBase brakes = base_of([&](double t) { return std::max(0.0, course(t)); });
  EXPECT_NEAR(brakes.acceleration_per_s2(0), braking, 0.02 * -braking);
  EXPECT_LT(brakes.covered(0), 0.2F) << "not on for a quarter of a second";
  const TransitionBase drives = base_of([&](double t) { return 0.2 + velocity * t - braking / 2 * t * t; });
  EXPECT_LT(drives.acceleration_per_s2(0), -braking);
  EXPECT_LT(drives.covered(0), 0.5F + 0.1F);
}

TEST(TransitionBase, AShortPastGivesWhatItCan) {
  TransitionRequest request{.past = AuMatrix::Constant(2, 1, 0.2F), .target = Eigen::VectorXf::Constant(1, 0.6F)};
  request.past(1, 0) = 0.21F;
  request.frames = 60;
  request.rate_hz = kRate_hz;
  TransitionBase base;
  make_transition_base(request, base);
  EXPECT_NEAR(base.velocity_per_s(0), 0.01 * kRate_hz, 1e-3);
  EXPECT_EQ(base.acceleration_per_s2(0), 0);
}

}  // namespace
}  // namespace risorius
