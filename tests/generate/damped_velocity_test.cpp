#include "generate/damped_velocity.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/allocation_counter.h"

namespace risorius {
namespace {

constexpr double kUpper = 1.2, kTau_s = 0.08;  // the default time constant

class Runner {
 public:
  explicit Runner(std::size_t aus = 1, const DampedVelocityOptions& options = {})
      : continuer_(std::make_unique<DampedVelocity>(std::vector<double>(aus, kUpper), options)), aus_(aus) {}
  Continuation at(double time_s, double value, AuState state = AuState::kObserved) {
    AuFrame frame;
    frame.header.capture_time_ns = std::llround(time_s * 1e9);
    frame.status = SolverStatus::kConverged;
    frame.count = static_cast<std::uint32_t>(aus_);
    for (std::size_t au = 0; au < aus_; ++au) {
      frame.intensity[au] = value;
      frame.state[au] = state;
    }
    Continuation out;
    EXPECT_TRUE(continuer_.process(frame, out)) << time_s;
    return out;
  }

 private:
  Continuer continuer_;
  std::size_t aus_;
};

TEST(DampedVelocity, FollowsItsFormulaOnAStraightLine) {
  Runner runner;
  Continuation out;
  for (int f = 0; f <= 12; ++f) out = runner.at(f / 60.0, 0.1 + f / 60.0);  // velocity 1 per s, x = 0.3 at 0.2 s
  for (std::uint32_t step = 0; step < out.step_count; ++step) {
    const double ahead_s = static_cast<double>(out.ahead_ns[step]) * 1e-9;
    EXPECT_NEAR(out.intensity[step][0], 0.3 + kTau_s * (1 - std::exp(-ahead_s / kTau_s)), 1e-5);
  }
}

TEST(DampedVelocity, LearnsNothingFromTimesThatNoClockReaches) {
  Runner runner;
  // Farther apart than 64 bits of nanoseconds can say.
  for (const double from_s : {-5.7e9, 5.7e9, -9.2e9, 9.2e9}) {
    for (int f = 0; f < 20; ++f) runner.at(from_s + f / 50.0, 0.02 * f);
  }
  Continuation out;
  for (int f = 0; f < 60; ++f) out = runner.at(f / 60.0, 0.5);
  for (std::uint32_t step = 0; step < out.step_count; ++step) {
    EXPECT_NEAR(out.intensity[step][0], 0.5, 1e-6);
    EXPECT_GT(out.standard_deviation[step][0], 0);
    EXPECT_LT(out.standard_deviation[step][0], 0.3);
  }
}

TEST(DampedVelocity, NeverLeavesTheBounds) {
  Runner runner;
  for (int f = 0; f < 600; ++f) {
    const Continuation out = runner.at(f / 60.0, std::clamp(0.6 + 2 * std::sin(0.5 * f), 0.0, kUpper));
    for (std::uint32_t step = 0; step < out.step_count; ++step) {
      EXPECT_GE(out.intensity[step][0], 0);
      EXPECT_LE(out.intensity[step][0], static_cast<float>(kUpper));
      EXPECT_TRUE(std::isfinite(out.standard_deviation[step][0]));
    }
  }
}

TEST(DampedVelocity, OneBadFrameDoesNotTurnTheVelocity) {
  Runner runner(1, {.window_ms = 100});
  Continuation out;
  for (int f = 0; f <= 30; ++f) out = runner.at(f / 60.0, f == 28 ? 1.0 : 0.2);
  EXPECT_NEAR(out.intensity[0][0], 0.2, 1e-6);
}

TEST(DampedVelocity, LearnsStandardDeviationsThatItsErrorsHave) {
  // Around a standstill with normal noise: the share of later values within 1.645 deviations must be near 90 %.
  Runner runner(1, {.memory_s = 30});
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<double> values;
  std::vector<Continuation> predictions;
  for (int f = 0; f < 3000; ++f) {
    values.push_back(0.6 + noise(random));
    predictions.push_back(runner.at(f / 60.0, values.back()));
  }
  for (std::uint32_t step = 0; step < predictions[0].step_count; ++step) {
    const int frames_ahead = static_cast<int>(predictions[0].ahead_ns[step] * 60 / 1'000'000'000);
    int inside = 0, scored = 0;
    for (int f = 1000; f + frames_ahead < 3000; ++f, ++scored) {
      const double error = values[f + frames_ahead] - predictions[f].intensity[step][0];
      inside += std::abs(error) <= 1.645 * predictions[f].standard_deviation[step][0];
    }
    EXPECT_NEAR(static_cast<double>(inside) / scored, 0.90, 0.05) << "step " << step;  // the bar: 85 to 95 %
  }
}

TEST(DampedVelocity, AnErrorCountsOnlyOnceItsTimeHasCome) {
  Runner runner;
  Continuation before, at_jump;
  for (int f = 0; f < 60; ++f) before = runner.at(f / 60.0, 0.5);
  at_jump = runner.at(1, 1.0);
  // Every horizon has predictions that end at the jump, so every deviation grows with it, and none grew ahead of it.
  for (std::uint32_t step = 0; step < before.step_count; ++step) {
    EXPECT_GT(at_jump.standard_deviation[step][0], before.standard_deviation[step][0]);
  }
  Runner still;
  Continuation quiet;
  for (int f = 0; f < 60; ++f) quiet = still.at(f / 60.0, 0.5);
  EXPECT_EQ(std::memcmp(&quiet, &before, sizeof quiet), 0);
}

TEST(DampedVelocity, WhatIsNotObservedStaysNotObserved) {
  Runner runner;
  for (int f = 0; f < 30; ++f) runner.at(f / 60.0, 0.01 * f);
  for (int f = 30; f < 60; ++f) {
    const Continuation out = runner.at(f / 60.0, 0.29, f % 2 == 0 ? AuState::kHeld : AuState::kNotObserved);
    for (std::uint32_t step = 0; step < out.step_count; ++step) {
      EXPECT_EQ(out.intensity[step][0], 0.29f);
      EXPECT_TRUE(std::isnan(out.standard_deviation[step][0]));
    }
  }
  const Continuation back = runner.at(1, 0.4);
  EXPECT_NEAR(back.intensity[0][0], 0.4, 1e-6);  // no velocity across the time it was not seen
  EXPECT_TRUE(std::isfinite(back.standard_deviation[0][0]));
}

TEST(DampedVelocity, AGapLeavesNoVelocity) {
  Runner runner;
  for (int f = 0; f < 30; ++f) runner.at(f / 60.0, 0.02 * f);
  EXPECT_NEAR(runner.at(2, 0.1).intensity[4][0], 0.1, 1e-6);
  EXPECT_NEAR(runner.at(0.5, 0.3).intensity[4][0], 0.3, 1e-6);  // time going back
}

TEST(DampedVelocity, AllocatesNothing) {
  DampedVelocity model(std::vector<double>(kMaxAus, kUpper));
  AuFrame frame;
  frame.count = kMaxAus;
  frame.state.fill(AuState::kObserved);
  Continuation out;
  out.au_count = kMaxAus;
  out.step_count = kMaxContinuationSteps;
  for (std::size_t step = 0; step < kMaxContinuationSteps; ++step)
    out.ahead_ns[step] = std::int64_t{50'000'000} * static_cast<int>(1 + step);
  const std::uint64_t before = test::allocations_of_this_thread();
  for (int f = 0; f < 300; ++f) {
    frame.header.capture_time_ns = std::int64_t{8'000'000} * f;
    frame.intensity.fill(0.5 + 0.4 * std::sin(0.1 * f));
    model.observe(frame);
    model.predict(out);
  }
  model.reset();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(DampedVelocity, RefusesOptionsOutOfRange) {
  EXPECT_THROW(DampedVelocity({}), std::invalid_argument);
  EXPECT_THROW(DampedVelocity(std::vector<double>(65, 1.2)), std::invalid_argument);
  EXPECT_THROW(DampedVelocity({0}), std::invalid_argument);
  EXPECT_THROW(DampedVelocity({1.2}, {.window_ms = 0}), std::invalid_argument);
  EXPECT_THROW(DampedVelocity({1.2}, {.time_constant_ms = std::numeric_limits<double>::quiet_NaN()}),
               std::invalid_argument);
  EXPECT_THROW(DampedVelocity({1.2}, {.memory_s = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
