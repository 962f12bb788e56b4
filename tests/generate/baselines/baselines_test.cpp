// All simple continuations: what they share, and each one's own formula.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "generate/baselines/double_exponential.h"
#include "generate/baselines/kalman_velocity.h"
#include "generate/baselines/linear_autoregression.h"
#include "generate/continuation_models.h"
#include "support/allocation_counter.h"
#include "support/test_data.h"

namespace risorius {
namespace {

constexpr double kUpper = 1.2, kRate_hz = 60;

AuFrame frame_at(double time_s, std::size_t aus, double value, AuState state = AuState::kObserved) {
  AuFrame frame;
  frame.header.capture_time_ns = std::llround(time_s * 1e9);
  frame.status = SolverStatus::kConverged;
  frame.count = static_cast<std::uint32_t>(aus);
  for (std::size_t au = 0; au < aus; ++au) {
    frame.intensity[au] = value;
    frame.state[au] = state;
  }
  return frame;
}

Continuation ask(ContinuationModel& model, std::size_t aus) {
  Continuation continuation;
  continuation.au_count = static_cast<std::uint32_t>(aus);
  continuation.step_count = 5;
  for (std::size_t step = 0; const double ms : {50, 100, 150, 250, 500})
    continuation.ahead_ns[step++] = static_cast<std::int64_t>(ms * 1e6);
  model.predict(continuation);
  return continuation;
}

/// Shows the model a series at 60 Hz and returns what it predicts from its end.
template <class Series>
Continuation after(ContinuationModel& model, int frames, Series series) {
  for (int f = 0; f < frames; ++f) model.observe(frame_at(f / kRate_hz, 1, series(f / kRate_hz)));
  return ask(model, 1);
}

std::unique_ptr<ContinuationModel> make(ContinuationKind kind, std::size_t aus = 1) {
  return make_continuation_model({.kind = kind}, std::vector<std::string>(aus, "AU1"),
                                 std::vector<double>(aus, kUpper));
}

/// A network knows no rest to the last digit: it has seen that faces relax, and says so by this much at most.
double tolerance_of(ContinuationKind kind) { return kind == ContinuationKind::kLearned ? 0.03 : 1e-6; }

TEST(ContinuationBaselines, AreFoundByTheirNames) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) EXPECT_EQ(make(entry.kind)->name(), entry.name);
}

TEST(ContinuationBaselines, AFaceAtRestStaysAtRest) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    const auto model = make(entry.kind);
    const Continuation out = after(*model, 60, [](double) { return 0.4; });
    for (std::size_t step = 0; step < 5; ++step)
      EXPECT_NEAR(out.intensity[step][0], 0.4, tolerance_of(entry.kind)) << entry.name;
  }
}

TEST(ContinuationBaselines, NeverLeaveTheBoundsAndAlwaysStateADeviation) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    const auto model = make(entry.kind);
    std::mt19937 random(3);
    for (int f = 0; f < 600; ++f) {
      const double value = std::clamp(0.6 + 1.5 * std::sin(0.4 * f), 0.0, kUpper);
      model->observe(frame_at(f / kRate_hz, 1, value));
      const Continuation out = ask(*model, 1);
      for (std::size_t step = 0; step < 5; ++step) {
        ASSERT_GE(out.intensity[step][0], 0) << entry.name;
        ASSERT_LE(out.intensity[step][0], static_cast<float>(kUpper)) << entry.name;
        ASSERT_GT(out.standard_deviation[step][0], 0) << entry.name;
      }
    }
  }
}

TEST(ContinuationBaselines, WhatIsNotObservedStaysNotObserved) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    const auto model = make(entry.kind, 2);
    for (int f = 0; f < 10; ++f) {
      AuFrame frame = frame_at(f / kRate_hz, 2, 0.1 * f);
      frame.state[1] = f < 8 ? AuState::kObserved : AuState::kHeld;
      if (f >= 8) frame.intensity[1] = 0.7;
      model->observe(frame);
    }
    const Continuation out = ask(*model, 2);
    EXPECT_FALSE(std::isnan(out.standard_deviation[0][0])) << entry.name;
    EXPECT_TRUE(std::isnan(out.standard_deviation[0][1])) << entry.name;
    EXPECT_EQ(out.intensity[0][1], 0.7F) << entry.name << ": the frame's last value";
  }
}

/// What a model says that has seen this one frame; a formula: that it stays.
double without_past(ContinuationKind kind, double time_s, double value, std::size_t step) {
  if (kind != ContinuationKind::kLearned) return value;
  const auto model = make(kind);
  model->observe(frame_at(time_s, 1, value));
  return static_cast<double>(ask(*model, 1).intensity[step][0]);
}

TEST(ContinuationBaselines, ALongGapBeginsTheMotionAnew) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    // What the learned one has learnt of a person, how much to believe its small residual, outlives the gap.
    const double tolerance = entry.kind == ContinuationKind::kLearned ? 1e-3 : 1e-6;
    const auto model = make(entry.kind);
    for (int f = 0; f < 30; ++f) model->observe(frame_at(f / kRate_hz, 1, 0.02 * f));
    model->observe(frame_at(2.0, 1, 0.3));
    const Continuation out = ask(*model, 1);
    for (std::size_t step = 0; step < 5; ++step)
      EXPECT_NEAR(out.intensity[step][0], without_past(entry.kind, 2.0, 0.3, step), tolerance) << entry.name;
    model->reset();
    model->observe(frame_at(0, 1, 0.9));
    EXPECT_NEAR(ask(*model, 1).intensity[4][0], without_past(entry.kind, 0, 0.9, 4), tolerance) << entry.name;
  }
}

TEST(ContinuationBaselines, AllocateNothing) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    const auto model = make(entry.kind, kMaxAus);
    const std::uint64_t before = test::allocations_of_this_thread();
    for (int f = 0; f < 100; ++f) {
      model->observe(frame_at(f / kRate_hz, kMaxAus, 0.5 + 0.4 * std::sin(0.1 * f)));
      ask(*model, kMaxAus);
    }
    EXPECT_EQ(test::allocations_of_this_thread(), before) << entry.name;
  }
}

TEST(ContinuationBaselines, RefuseBoundsThatAreNone) {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    EXPECT_THROW(make_continuation_model({.kind = entry.kind}, {}, {}), std::invalid_argument) << entry.name;
    EXPECT_THROW(make_continuation_model({.kind = entry.kind}, {"AU1"}, {0}), std::invalid_argument) << entry.name;
    EXPECT_THROW(make_continuation_model({.kind = entry.kind}, {"AU1"}, {1, 1}), std::invalid_argument);
  }
}

TEST(DoubleExponential, FollowsAStraightLineInTheEnd) {
  DoubleExponential model({kUpper}, {.time_constant_ms = 30});
  const Continuation out = after(model, 120, [](double t) { return 0.1 + 0.2 * t; });
  const double now = 0.1 + 0.2 * 119 / kRate_hz;
  for (std::size_t step = 0; step < 5; ++step)
    EXPECT_NEAR(out.intensity[step][0], now + 0.2 * static_cast<double>(out.ahead_ns[step]) * 1e-9, 1e-4);
  EXPECT_THROW(DoubleExponential({kUpper}, {.time_constant_ms = 0}), std::invalid_argument);
}

TEST(KalmanVelocity, FollowsAStraightLineThroughNoise) {
  KalmanVelocity model({kUpper}, {.noise = 0.01, .acceleration_noise = 1e-3});
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.01);
  const Continuation out = after(model, 120, [&](double t) { return 0.1 + 0.2 * t + noise(random); });
  const double now = 0.1 + 0.2 * 119 / kRate_hz;
  // Of 120 frames with so little acceleration, value and slope are known to a fraction of the noise.
  for (std::size_t step = 0; step < 5; ++step)
    EXPECT_NEAR(out.intensity[step][0], now + 0.2 * static_cast<double>(out.ahead_ns[step]) * 1e-9, 0.015);
  EXPECT_THROW(KalmanVelocity({kUpper}, {.noise = 0}), std::invalid_argument);
  EXPECT_THROW(KalmanVelocity({kUpper}, {.acceleration_noise = -1}), std::invalid_argument);
}

TEST(KalmanVelocity, TheFirstTwoFramesGiveTheOptimalGain) {
  // After one frame xx = r, vv = 4; after dt: xx = r + 4 dt^2 + q dt^3 / 3, so the gain of the second is xx / (xx + r).
  KalmanVelocity model({kUpper}, {.noise = 0.1, .acceleration_noise = 6});
  model.observe(frame_at(0, 1, 0.2));
  model.observe(frame_at(0.1, 1, 0.4));
  const double xx = 0.01 + 4 * 0.01 + 6 * 0.001 / 3, xv = 4 * 0.1 + 6 * 0.01 / 2;
  const double x = 0.2 + xx / (xx + 0.01) * 0.2, v = xv / (xx + 0.01) * 0.2;
  EXPECT_NEAR(ask(model, 1).intensity[1][0], x + 0.1 * v, 1e-6);
}

TEST(LinearAutoregression, FitsTheRuleThatMadeASeries) {
  // x(t+1) - x(t) = 0.9 (x(t) - x(t-1)): weight -0.9 of the first lag, and -(0.9 + 0.81) two ahead.
  AuMatrix series(4000, 1);
  series(0, 0) = 0;
  std::mt19937 random(2);
  std::normal_distribution<double> shock(0, 0.01);
  double x = 0, step = 0;
  for (Eigen::Index row = 1; row < 4000; ++row) {
    step = 0.9 * step + shock(random);
    x += step;
    series(row, 0) = static_cast<float>(x);
  }
  const AutoregressionTable table = fit_autoregression(series, 0);
  // Each step weight has a standard error of 1 / sqrt(4000) = 0.016; a lag's weight is the difference of two.
  EXPECT_NEAR(table.weights[0][0], -0.9, 0.1);
  double later = 0;
  for (const double weight : table.weights[0]) later += weight;
  EXPECT_NEAR(later, -0.9, 0.15) << "the other lags say little";
  EXPECT_THROW(fit_autoregression(AuMatrix::Zero(10, 1)), std::invalid_argument);
}

TEST(LinearAutoregression, AppliesItsTableAtItsHorizonsAndBetween) {
  AutoregressionTable table;
  for (std::size_t h = 0; h < table.weights.size(); ++h) table.weights[h][0] = -AutoregressionTable::kHorizons[h];
  LinearAutoregression model({kUpper}, table);  // w_1(h) = -h / d: the line through the last lag goes on
  const Continuation out = after(model, 30, [](double t) { return 0.2 + 0.3 * t; });
  const double now = 0.2 + 0.3 * 29 / kRate_hz;
  for (std::size_t step = 0; step < 5; ++step)
    EXPECT_NEAR(out.intensity[step][0], now + 0.3 * static_cast<double>(out.ahead_ns[step]) * 1e-9, 1e-5) << step;
}

}  // namespace
}  // namespace risorius
