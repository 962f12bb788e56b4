#include "generate/shown_face.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "generate/interpolation.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kFrame_ns = 10 * kMs;  // 100 Hz
constexpr double kFastest_per_s = 20;         // nothing on a face is faster; a change within 1 ms stays below 0.02

AuFrame frame_at(std::int64_t time_ns, double first, double second = 0.5) {
  AuFrame frame;
  frame.header.capture_time_ns = time_ns;
  frame.header.sequence = static_cast<std::uint64_t>(time_ns / kFrame_ns);
  frame.status = SolverStatus::kConverged;
  frame.count = 2;
  frame.state = {AuState::kObserved, AuState::kObserved};
  frame.intensity = {first, second};
  frame.standard_deviation = {0.01, 0.02};
  return frame;
}

AuFrame without_face(std::int64_t time_ns) {
  AuFrame frame = frame_at(time_ns, 0, 0);
  frame.status = SolverStatus::kTooFewMarkers;
  return frame;
}

/// The first AU goes on at 1 per s, damped; the second stays.
Continuation continuation_of(const AuFrame& frame) {
  Continuation c;
  c.header = frame.header;
  c.au_count = 2;
  c.step_count = 3;
  c.ahead_ns = {50 * kMs, 100 * kMs, 500 * kMs};
  const std::array<double, 3> way{0.05, 0.08, 0.1};
  for (std::size_t step = 0; step < 3; ++step) {
    c.intensity[step][0] = static_cast<float>(frame.intensity[0] + way[step]);
    c.intensity[step][1] = static_cast<float>(frame.intensity[1]);
    c.standard_deviation[step][0] = c.standard_deviation[step][1] = 0.1F * static_cast<float>(step + 1);
  }
  return c;
}

class Shown {
 public:
  explicit Shown(const ShownOptions& options = {.max_rate_hz = 1000}) : face({1.2, 1.2}, options) {}
  /// Half a second of frames that end at `last_ns` with these values, and their continuations.
  void talk_until(std::int64_t last_ns, double first, double second = 0.5) {
    for (std::int64_t t = last_ns - 50 * kFrame_ns; t <= last_ns; t += kFrame_ns) {
      const AuFrame frame = frame_at(t, first, second);
      face.process(frame, out);
      face.use(continuation_of(frame));
    }
  }
  double first() const { return out.aus.intensity[0]; }

  ShownFace face;
  ShownFrame out;
};

TEST(ShownFace, SolvedFramesPassUnchanged) {
  Shown shown;
  const AuFrame frame = frame_at(0, 0.3);
  ASSERT_TRUE(shown.face.process(frame, shown.out));
  EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
  EXPECT_EQ(shown.out.aus.kind, AuFrameKind::kSolved);
  EXPECT_FLOAT_EQ(static_cast<float>(shown.first()), 0.3F);
  EXPECT_EQ(shown.out.aus.standard_deviation[1], 0.02);
}

TEST(ShownFace, ShowsAtMostItsRateOfCaptureTime) {
  Shown shown({.max_rate_hz = 60});
  int frames = 0;
  for (int f = 0; f < 240; ++f) frames += shown.face.process(frame_at(f * 1'000'000'000LL / 240, 0.3), shown.out);
  EXPECT_EQ(frames, 60);
}

TEST(ShownFace, ABridgeBeginsWhereTheFramesEndedAndFollowsTheContinuation) {
  Shown shown;
  shown.talk_until(0, 0.3);
  ASSERT_TRUE(shown.face.pass(kMs / 100, shown.out));
  EXPECT_EQ(shown.out.origin, ShownOrigin::kBridge);
  EXPECT_EQ(shown.out.aus.kind, AuFrameKind::kPredicted);
  EXPECT_NEAR(shown.first(), 0.3, 1e-4);
  for (const auto& [ms, value] : {std::pair{50, 0.35}, {100, 0.38}, {500, 0.4}}) {
    ASSERT_TRUE(shown.face.pass(ms * kMs, shown.out));
    EXPECT_NEAR(shown.first(), value, 1e-6) << ms;
    EXPECT_EQ(shown.out.aus.header.capture_time_ns, ms * kMs);
  }
  ASSERT_TRUE(shown.face.pass(75 * kMs, shown.out));
  EXPECT_NEAR(shown.out.aus.standard_deviation[0], 0.15, 1e-6) << "between the horizons";
}

TEST(ShownFace, AContinuationOfAnEarlierFrameIsMovedToTheLast) {
  Shown shown;
  shown.face.process(frame_at(0, 0.3), shown.out);
  shown.face.use(continuation_of(frame_at(0, 0.3)));
  shown.face.process(frame_at(50 * kMs, 0.45), shown.out);  // 0.1 above what was predicted for it
  shown.face.pass(kMs / 100, shown.out);
  EXPECT_NEAR(shown.first(), 0.45, 1e-4);
  shown.face.pass(50 * kMs, shown.out);
  EXPECT_NEAR(shown.first(), 0.38 + 0.1, 1e-6);
}

TEST(ShownFace, AfterItsLimitABridgeFadesToNeutralAndEnds) {
  Shown shown({.max_rate_hz = 1000, .bridge_s = 0.5, .fade_s = 1});
  shown.talk_until(0, 0.3);
  double before = 0.4;
  for (std::int64_t ms = 510; ms <= 1500; ms += 10) {
    ASSERT_TRUE(shown.face.pass(ms * kMs, shown.out)) << ms;
    EXPECT_EQ(shown.out.origin, ShownOrigin::kFade);
    EXPECT_LE(shown.first(), before);
    EXPECT_LE(before - shown.first(), 0.4 * 1.875 * 0.01 + 1e-6) << "minimum jerk: 15/8 of the mean speed";
    before = shown.first();
  }
  EXPECT_EQ(shown.first(), 0);
  EXPECT_EQ(shown.out.aus.intensity[1], 0);
  EXPECT_FALSE(shown.face.pass(1510 * kMs, shown.out)) << "neutral by now";
  EXPECT_FALSE(shown.face.is_showing());
}

TEST(ShownFace, FramesThatComeAgainAreRejoinedWithoutAStep) {
  for (const std::int64_t lost_ms : {100, 300, 500, 1200, 5000}) {
    Shown shown({.max_rate_hz = 1000, .rejoin_s = 0.2});
    shown.talk_until(0, 0.3);
    shown.face.pass((lost_ms - 1) * kMs, shown.out);
    const double before = shown.first();
    const std::int64_t back_ns = lost_ms * kMs;
    ASSERT_TRUE(shown.face.process(frame_at(back_ns, 0.9), shown.out));
    EXPECT_NEAR(shown.first(), before, kFastest_per_s * 1e-3) << lost_ms;
    EXPECT_EQ(shown.out.origin, ShownOrigin::kRejoin);
    EXPECT_EQ(shown.out.aus.kind, AuFrameKind::kPredicted);
    double last = shown.first();
    for (std::int64_t ms = 1; ms < 200; ++ms) {
      shown.face.process(frame_at(back_ns + ms * kMs, 0.9), shown.out);
      EXPECT_LT(std::abs(shown.first() - last), kFastest_per_s * 1e-3) << ms;
      last = shown.first();
    }
    shown.face.process(frame_at(back_ns + 201 * kMs, 0.9), shown.out);
    EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
    EXPECT_FLOAT_EQ(static_cast<float>(shown.first()), 0.9F);
  }
}

TEST(ShownFace, FramesWithoutAFaceAreBridgedToo) {
  Shown shown;
  shown.talk_until(0, 0.3);
  ASSERT_TRUE(shown.face.process(without_face(50 * kMs), shown.out));
  EXPECT_EQ(shown.out.origin, ShownOrigin::kBridge);
  EXPECT_NEAR(shown.first(), 0.35, 1e-6);
  EXPECT_FALSE(Shown().face.process(without_face(0), shown.out)) << "no face was ever there";
}

TEST(ShownFace, WithoutAContinuationTheFaceIsHeld) {
  Shown shown;
  shown.face.process(frame_at(0, 0.3), shown.out);
  ASSERT_TRUE(shown.face.pass(300 * kMs, shown.out));
  EXPECT_NEAR(shown.first(), 0.3, 1e-6);
  EXPECT_TRUE(std::isnan(shown.out.aus.standard_deviation[0]));
}

TEST(ShownFace, WhatIsNotObservedStaysNotObserved) {
  Shown shown;
  AuFrame frame = frame_at(0, 0.3);
  frame.state[1] = AuState::kNotObserved;
  shown.face.process(frame, shown.out);
  shown.face.pass(50 * kMs, shown.out);
  EXPECT_EQ(shown.out.aus.state[1], AuState::kNotObserved);
}

class Target : public ::testing::Test {
 protected:
  void go(double seconds, double hold_s, double return_s, float value = 1) {
    const LiveTarget target{Eigen::VectorXf::Constant(2, value), seconds, hold_s, return_s};
    const TransitionRequest request = shown.face.request_of(target);
    AuMatrix course;
    make_interpolation("quintic")->generate(request, course);
    shown.face.follow(target, request, course, shown.face.now_ns());
  }
  Shown shown;
};

TEST_F(Target, GoesFromTheFaceToTheTargetHoldsAndReturns) {
  shown.talk_until(0, 0.3);
  go(1, 0.5, 0.4);
  double before = 0.3;
  for (std::int64_t ms = 1; ms <= 2000; ++ms) {
    ASSERT_TRUE(shown.face.process(frame_at(ms * kMs, 0.3), shown.out));
    EXPECT_LT(std::abs(shown.first() - before), 0.01) << ms;
    before = shown.first();
    if (ms == 1000) {
      EXPECT_NEAR(shown.first(), 1, 1e-5) << "there in T seconds";
    }
    if (ms == 1499) {
      EXPECT_EQ(shown.out.origin, ShownOrigin::kTarget);
    }
    if (ms == 1600) {
      EXPECT_EQ(shown.out.origin, ShownOrigin::kRejoin);
    }
  }
  EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
  EXPECT_NEAR(shown.first(), 0.3, 1e-6);
  EXPECT_FALSE(shown.face.has_target());
}

TEST_F(Target, ContinuesWhileNoFramesCome) {
  shown.talk_until(0, 0.3);
  go(1, 10, 1);
  ASSERT_TRUE(shown.face.pass(3000 * kMs, shown.out)) << "a target holds longer than a bridge";
  EXPECT_NEAR(shown.first(), 1, 1e-5);
  EXPECT_EQ(shown.out.origin, ShownOrigin::kTarget);
}

TEST_F(Target, AskedOfAFaceThatHasFadedGoesThereAndFadesAgain) {
  shown.talk_until(0, 0.3);
  std::int64_t ms = 1;
  while (shown.face.pass(ms * kMs, shown.out)) ++ms;
  ASSERT_NEAR(shown.first(), 0, 1e-6);
  ms += 3000;  // in which nothing is shown
  shown.face.note_time(ms * kMs);
  const std::int64_t asked_ms = ms;
  go(1, 0.5, 0.4);
  double before = 0, highest = 0;
  for (++ms; shown.face.pass(ms * kMs, shown.out); ++ms) {
    ASSERT_LT(ms, asked_ms + 5000) << "it ends";
    EXPECT_LT(std::abs(shown.first() - before), 0.01) << ms;
    before = shown.first();
    highest = std::max(highest, before);
    if (ms == asked_ms + 1000) {
      EXPECT_NEAR(shown.first(), 1, 1e-3);
    }
  }
  EXPECT_NEAR(highest, 1, 1e-5);
  EXPECT_NEAR(shown.first(), 0, 1e-6) << "neutral again, not left on the target";
  EXPECT_GE(ms, asked_ms + 1900) << "there, held, and back";
  EXPECT_FALSE(shown.face.is_showing());
}

TEST_F(Target, ThatOutlivesTheSourceFadesAndSoDoesOneThatIsReleased) {
  for (const bool is_released : {false, true}) {
    shown = Shown();
    shown.talk_until(0, 0.3);
    go(0.5, is_released ? 100 : 3, 0.4);
    double before = 0.3;
    std::int64_t ms = 1;
    for (; shown.face.pass(ms * kMs, shown.out); ++ms) {
      ASSERT_LT(ms, 10'000);
      EXPECT_LT(std::abs(shown.first() - before), 0.02) << ms;
      before = shown.first();
      if (is_released && ms == 4000) shown.face.release();
    }
    EXPECT_GE(ms, 3900);
    EXPECT_NEAR(shown.first(), 0, 1e-6);
  }
}

TEST_F(Target, IsReleasedAtOnceWithoutAStep) {
  shown.talk_until(0, 0.3);
  go(0.2, 10, 0.3);
  shown.face.process(frame_at(400 * kMs, 0.2), shown.out);
  shown.face.release();
  shown.face.process(frame_at(401 * kMs, 0.2), shown.out);
  EXPECT_NEAR(shown.first(), 1, 0.01);
  shown.face.process(frame_at(800 * kMs, 0.2), shown.out);
  EXPECT_NEAR(shown.first(), 0.2, 1e-6);
}

TEST_F(Target, ACourseThatCameLateMakesNoStep) {
  shown.talk_until(0, 0.3);
  const LiveTarget target{Eigen::VectorXf::Constant(2, 1.0F), 0.5, 1, 1};
  const TransitionRequest request = shown.face.request_of(target);
  const std::int64_t began_ns = shown.face.now_ns();
  AuMatrix course;
  make_interpolation("minimum_jerk")->generate(request, course);
  for (std::int64_t ms = 1; ms <= 100; ++ms)
    shown.face.process(frame_at(ms * kMs, 0.3 + 0.002 * static_cast<double>(ms)), shown.out);
  shown.face.follow(target, request, course, began_ns);
  const double before = shown.first();
  shown.face.process(frame_at(101 * kMs, 0.5), shown.out);
  EXPECT_NEAR(shown.first(), before, 0.02);
  shown.face.process(frame_at(500 * kMs, 0.5), shown.out);
  EXPECT_NEAR(shown.first(), 1, 1e-5) << "it is there in time all the same";
}

TEST_F(Target, TheRequestsPastIsWhatWasShown) {
  for (std::int64_t ms = 0; ms <= 300; ms += 10)
    shown.face.process(frame_at(ms * kMs, 0.001 * static_cast<double>(ms)), shown.out);
  const TransitionRequest request =
      shown.face.request_of({.target = Eigen::VectorXf::Zero(2), .seconds = 0.5, .hold_s = 0, .return_s = 0});
  ASSERT_EQ(request.past.rows(), ShownFace::kPastFrames);
  EXPECT_EQ(request.frames, 60);
  for (Eigen::Index row = 0; row < request.past.rows(); ++row)
    EXPECT_NEAR(request.past(row, 0), 0.3 - static_cast<double>(ShownFace::kPastFrames - 1 - row) / 120, 1e-5);
}

TEST_F(Target, IsRefusedWithoutAFaceOrOutOfRange) {
  const LiveTarget good{Eigen::VectorXf::Zero(2), 1, 1, 1};
  EXPECT_THROW(shown.face.request_of(good), std::invalid_argument) << "nothing was shown yet";
  shown.talk_until(0, 0.3);
  EXPECT_NO_THROW(shown.face.request_of(good));
  const auto refused = [&](auto spoil) {
    LiveTarget bad = good;
    spoil(bad);
    EXPECT_THROW(shown.face.request_of(bad), std::invalid_argument);
  };
  refused([](auto& t) { t.target = Eigen::VectorXf::Zero(3); });
  refused([](auto& t) { t.target[0] = std::numeric_limits<float>::quiet_NaN(); });
  refused([](auto& t) { t.seconds = 0; });
  refused([](auto& t) { t.hold_s = -1; });
  refused([](auto& t) { t.return_s = std::numeric_limits<double>::infinity(); });
}

TEST(ShownFace, AClockThatGoesBackIsRejoinedWithoutAStep) {
  Shown shown;
  shown.talk_until(1000 * kMs, 0.3);
  shown.face.pass(100 * kMs, shown.out);
  const double last = shown.first();
  ASSERT_TRUE(shown.face.process(frame_at(0, 0.9), shown.out));
  EXPECT_EQ(shown.out.origin, ShownOrigin::kRejoin);
  EXPECT_NEAR(shown.first(), last, 1e-6);
  ASSERT_TRUE(shown.face.process(frame_at(2000 * kMs, 0.9), shown.out));
  EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
  EXPECT_FLOAT_EQ(static_cast<float>(shown.first()), 0.9F);
}

TEST(ShownFace, ASourceThatStoodStillIsRejoinedWithoutAStep) {
  for (const std::int64_t silence_ms : {300, 1500, 5000}) {
    Shown shown;
    shown.talk_until(1000 * kMs, 0.9);
    for (std::int64_t ms = 1; ms <= silence_ms; ++ms) shown.face.pass(ms * kMs, shown.out);
    double before = shown.first();
    // Its clock has gone on for 10 ms only.
    for (std::int64_t ms = 1010; ms < 2000; ++ms) {
      ASSERT_TRUE(shown.face.process(frame_at(ms * kMs, 0.9), shown.out));
      EXPECT_LT(std::abs(shown.first() - before), 0.02) << silence_ms << ": " << ms;
      before = shown.first();
    }
    EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
    EXPECT_FLOAT_EQ(static_cast<float>(shown.first()), 0.9F);
  }
}

TEST(ShownFace, ATakeThatEndedFadesAndTheNextOneIsRejoinedWhateverItsClock) {
  for (const std::int64_t next_ns : {std::int64_t{0}, 60'000 * kMs}) {
    for (const std::int64_t pause_ms : {0, 100, 4000}) {
      Shown shown;
      shown.talk_until(1000 * kMs, 0.9);
      shown.face.end();
      double last = 0.9;
      for (std::int64_t ms = 1; ms <= pause_ms; ++ms) {
        if (!shown.face.pass(ms * kMs, shown.out)) break;
        EXPECT_LT(std::abs(shown.first() - last), kFastest_per_s * 1e-3);
        last = shown.first();
      }
      EXPECT_FALSE(shown.face.process(without_face(next_ns), shown.out)) << "it has nothing to rejoin yet";
      for (std::int64_t ms = 0; ms < 400; ++ms) {
        ASSERT_TRUE(shown.face.process(frame_at(next_ns + ms * kMs, 0.1), shown.out));
        EXPECT_LT(std::abs(shown.first() - last), kFastest_per_s * 1e-3) << ms << " ms after " << pause_ms;
        last = shown.first();
      }
      EXPECT_NEAR(last, 0.1, 1e-6);
      EXPECT_EQ(shown.out.origin, ShownOrigin::kSolved);
    }
  }
}

TEST(ShownFace, AllocatesNothing) {
  Shown shown;
  const std::uint64_t before = test::allocations_of_this_thread();
  shown.talk_until(0, 0.3);
  for (int ms = 1; ms < 400; ms += 7) shown.face.pass(ms * kMs, shown.out);
  shown.talk_until(5000 * kMs, 0.8);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(ShownFace, RefusesOptionsOutOfRange) {
  EXPECT_THROW(ShownFace({}), std::invalid_argument);
  EXPECT_THROW(ShownFace({0}), std::invalid_argument);
  EXPECT_THROW(ShownFace({1.2}, {.max_rate_hz = 0}), std::invalid_argument);
  EXPECT_THROW(ShownFace({1.2}, {.bridge_s = 3}), std::invalid_argument);
  EXPECT_THROW(ShownFace({1.2}, {.fade_s = 0}), std::invalid_argument);
  EXPECT_THROW(ShownFace({1.2}, {.rejoin_s = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
