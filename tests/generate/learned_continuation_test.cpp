#include "generate/learned_continuation.h"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <stdexcept>

#include "capture/errors.h"
#include "made_weights.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

const std::vector<std::string> kNames{"AU12L", "AU12R", "AU27"};
const std::vector<double> kUpper(3, 1.2);

Safetensors weights(float reach) {
  Safetensors file;
  file.metadata["model"] = "continuation";
  test::add_dense(file, "input", 16, kContinuationWidth, reach);
  test::add_dense(file, "first", 16, 16, reach);
  test::add_dense(file, "second", 16, 16, reach);
  test::add_dense(file, "output", 10, 16, reach);
  return file;
}

AuFrame frame_at(double time_s, double value, AuState state = AuState::kObserved) {
  AuFrame frame;
  frame.header.capture_time_ns = std::llround(time_s * 1e9);
  frame.status = SolverStatus::kConverged;
  frame.count = 3;
  for (std::size_t au = 0; au < 3; ++au) {
    frame.intensity[au] = value;
    frame.state[au] = AuState::kObserved;
  }
  frame.state[1] = state;
  return frame;
}

Continuer continuer(float reach) {
  return Continuer(std::make_unique<LearnedContinuation>(weights(reach), "test", kNames, kUpper));
}

TEST(LearnedContinuation, WithoutAResidualItBeginsAsDampedVelocity) {
  Continuer one = continuer(0);
  Continuation out;
  // Three frames: the first prediction is not yet due, so that nothing is learnt of this person.
  for (int i = 0; i <= 2; ++i) one.process(frame_at(i / 60.0, 0.48 + 0.6 * i / 60.0), out);
  for (std::size_t step = 0; step < 5; ++step) {
    const double h = static_cast<double>(out.ahead_ns[step]) * 1e-9;
    EXPECT_NEAR(out.intensity[step][0], 0.5 + 0.6 * 0.08 * (1 - std::exp(-h / 0.08)), 1e-4) << h;
    EXPECT_GT(out.standard_deviation[step][0], 0);
  }
}

TEST(LearnedContinuation, LearnsHowThisPersonGoesOn) {
  // Whoever moves evenly, to and fro, is no damped velocity: the line goes on.
  const auto value = [](int i) { return 0.2 + 0.5 * std::abs((i % 240) - 120) / 120.0; };
  Continuer one = continuer(0);
  Continuation out;
  double early = 0, late = 0;
  for (int i = 0; i < 2400; ++i) {
    one.process(frame_at(i / 60.0, value(i)), out);
    const double error = std::abs(out.intensity[1][0] - value(i + 6));  // 100 ms
    if (i >= 10 && i < 110) early += error;
    if (i >= 2290 && i < 2390) late += error;
  }
  EXPECT_LT(late, 0.3 * early);
}

TEST(LearnedContinuation, StaysFiniteAndWithinBoundsWhateverTheWeightsAndFrames) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> value(-0.2, 1.4);
  for (const float reach : {0.3F, 3.0F, 300.0F}) {
    Continuer one = continuer(reach);
    Continuation out;
    for (int i = 0; i < 300; ++i) {
      if (!one.process(frame_at(i / 60.0, value(random)), out)) continue;
      for (std::size_t step = 0; step < out.step_count; ++step) {
        for (std::size_t au = 0; au < 3; ++au) {
          ASSERT_GE(out.intensity[step][au], 0);
          ASSERT_LE(out.intensity[step][au], 1.2F);
          ASSERT_TRUE(std::isfinite(out.standard_deviation[step][au]) && out.standard_deviation[step][au] > 0);
        }
      }
    }
  }
}

TEST(LearnedContinuation, WhatIsNotObservedHasNoDeviationAndKeepsItsValue) {
  Continuer one = continuer(0.3F);
  Continuation out;
  for (int i = 0; i < 30; ++i) one.process(frame_at(i / 60.0, 0.4, AuState::kHeld), out);
  for (std::size_t step = 0; step < out.step_count; ++step) {
    EXPECT_TRUE(std::isnan(out.standard_deviation[step][1]));
    EXPECT_FLOAT_EQ(out.intensity[step][1], 0.4F);
    EXPECT_FALSE(std::isnan(out.standard_deviation[step][0]));
  }
}

TEST(LearnedContinuation, ItsDeviationsBecomeHonest) {
  // Jumps at random times cannot be foreseen: the untrained network's deviations are wrong, and are corrected.
  Continuer one = continuer(0.2F);
  std::mt19937_64 random(7);
  std::vector<double> x;
  double level = 0.5;
  for (int i = 0; i < 12'000; ++i) {
    if (random() % 20 == 0) level = 0.1 + 0.8 * static_cast<double>(random() % 1000) / 1000;
    x.push_back((x.empty() ? level : 0.8 * x.back() + 0.2 * level));
  }
  std::array<int, 5> within{}, all{};
  Continuation out;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!one.process(frame_at(static_cast<double>(i) / 60, x[i]), out) || i < 4000) continue;
    for (std::size_t step = 0; step < 5; ++step) {
      const auto later = i + static_cast<std::size_t>(std::llround(static_cast<double>(out.ahead_ns[step]) * 60e-9));
      if (later >= x.size()) continue;
      ++all[step];
      if (std::abs(out.intensity[step][0] - x[later]) <= 1.645 * static_cast<double>(out.standard_deviation[step][0]))
        ++within[step];
    }
  }
  for (std::size_t step = 0; step < 5; ++step)
    EXPECT_NEAR(static_cast<double>(within[step]) / all[step], 0.9, 0.03) << step;
}

TEST(LearnedContinuation, OtherHorizonsLieBetweenItsOwn) {
  Continuer one(std::make_unique<LearnedContinuation>(weights(0.3F), "test", kNames, kUpper),
                {60, {1e-3, 50, 75, 100, 500, 1000}});
  Continuation out;
  for (int i = 0; i <= 30; ++i) one.process(frame_at(i / 60.0, 0.2 + 0.6 * i / 60.0), out);
  EXPECT_NEAR(out.intensity[0][0], 0.5, 1e-4) << "nothing leaps at the present";
  EXPECT_NEAR(out.intensity[2][0], (out.intensity[1][0] + out.intensity[3][0]) / 2, 1e-6);
  EXPECT_EQ(out.intensity[4][0], out.intensity[5][0]);
}

TEST(LearnedContinuation, MirroredFacesGoOnMirrored) {
  Continuer a = continuer(0.3F), b = continuer(0.3F);
  Continuation out_a, out_b;
  for (int i = 0; i < 40; ++i) {
    AuFrame frame = frame_at(i / 60.0, 0.3 + 0.2 * std::sin(i / 5.0)), mirrored = frame;
    frame.intensity[0] = mirrored.intensity[1] = 0.5 + 0.3 * std::cos(i / 4.0);
    a.process(frame, out_a);
    b.process(mirrored, out_b);
  }
  for (std::size_t step = 0; step < 5; ++step) EXPECT_NEAR(out_a.intensity[step][0], out_b.intensity[step][1], 1e-6);
}

TEST(LearnedContinuation, AllocatesNothingPerFrame) {
  Continuer one = continuer(0.3F);
  Continuation out;
  for (int i = 0; i < 100; ++i) one.process(frame_at(i / 60.0, 0.3 + 0.2 * std::sin(i / 5.0)), out);
  const auto before = test::allocations_of_this_thread();
  for (int i = 100; i < 200; ++i) one.process(frame_at(i / 60.0, 0.3 + 0.2 * std::sin(i / 5.0)), out);
  one.process(frame_at(0, 0.1), out);  // a reset
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(LearnedContinuation, RefusesWhatDoesNotFit) {
  EXPECT_THROW(LearnedContinuation(weights(1), "test", {}, {}), std::invalid_argument);
  EXPECT_THROW(LearnedContinuation(weights(1), "test", kNames, {1.0}), std::invalid_argument);
  Safetensors other = weights(1);
  other.metadata["model"] = "expression_generator";
  EXPECT_THROW(LearnedContinuation(other, "test", kNames, kUpper), UserError);
  other = weights(1);
  other.tensors.erase("second.weight");
  EXPECT_THROW(LearnedContinuation(other, "test", kNames, kUpper), UserError);
}

}  // namespace
}  // namespace risorius
