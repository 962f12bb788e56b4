#include "daemon/arrival_forecast.h"

#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

constexpr std::int64_t kUs = 1'000, kMs = 1'000'000;
constexpr std::int64_t kFrameTime = 5 * kMs;
constexpr double kShare = 0.05;  // 250 us

/// Frames of a frame time each, every one late by up to so much.
std::int64_t feed(ArrivalForecast& forecast, int frames, std::int64_t from_ns, std::int64_t latest_ns = 0) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int64_t> late(0, latest_ns);
  std::int64_t at_ns = from_ns;
  for (int f = 0; f < frames; ++f) {
    at_ns = from_ns + f * kFrameTime + late(random);
    forecast.frame_came(at_ns);
  }
  return at_ns;
}

TEST(ArrivalForecast, SurroundsTheNextFrameOfASteadyStream) {
  ArrivalForecast forecast(kShare);
  const std::int64_t last_ns = feed(forecast, 100, kMs);
  ASSERT_TRUE(forecast.window());
  EXPECT_LT(forecast.window()->from_ns, last_ns + kFrameTime - 50 * kUs) << "waking takes so long";
  EXPECT_GT(forecast.window()->until_ns, last_ns + kFrameTime);
  EXPECT_LE(forecast.window()->until_ns - forecast.window()->from_ns, 250 * kUs);
  EXPECT_GE(forecast.foreseen().value(), 80u);
  EXPECT_EQ(forecast.missed().value(), 0u);
}

TEST(ArrivalForecast, WidensWithTheJitterAndCatchesMostFrames) {
  ArrivalForecast forecast(kShare), steady(kShare);
  feed(forecast, 2000, kMs, 60 * kUs);
  feed(steady, 2000, kMs);
  ASSERT_TRUE(forecast.window());
  EXPECT_GT(forecast.window()->until_ns - forecast.window()->from_ns,
            steady.window()->until_ns - steady.window()->from_ns);
  EXPECT_GT(forecast.foreseen().value(), 20 * forecast.missed().value());
}

TEST(ArrivalForecast, GivesUpWhereTheRhythmIsTooLooseForItsShare) {
  ArrivalForecast forecast(kShare);
  feed(forecast, 2000, kMs, 2 * kMs);
  EXPECT_FALSE(forecast.window());
}

TEST(ArrivalForecast, StaysAsleepAtRatesWhereWakingWouldTakeTheWholeShare) {
  ArrivalForecast forecast(kShare);
  for (int f = 1; f < 1000; ++f) forecast.frame_came(f * kMs);
  EXPECT_FALSE(forecast.window());
}

TEST(ArrivalForecast, OfShareZeroNeverHasAWindow) {
  ArrivalForecast forecast(0);
  feed(forecast, 1000, kMs);
  EXPECT_FALSE(forecast.window());
  EXPECT_EQ(forecast.missed().value(), 0u);
}

TEST(ArrivalForecast, KeepsItsRhythmOverLostFramesAndBursts) {
  ArrivalForecast forecast(kShare);
  std::int64_t at_ns = feed(forecast, 100, kMs);
  at_ns += 4 * kFrameTime;  // three are lost
  forecast.frame_came(at_ns);
  EXPECT_EQ(forecast.missed().value(), 1u);
  forecast.frame_came(at_ns + 2 * kUs);  // two at once
  ASSERT_TRUE(forecast.window());
  EXPECT_NEAR(static_cast<double>(forecast.window()->until_ns - at_ns), static_cast<double>(kFrameTime), 60e3);
}

TEST(ArrivalForecast, LearnsAnotherRhythm) {
  ArrivalForecast forecast(kShare);
  std::int64_t at_ns = feed(forecast, 100, kMs);
  for (int f = 0; f < 100; ++f) forecast.frame_came(at_ns += 3 * kFrameTime);
  ASSERT_TRUE(forecast.window());
  EXPECT_LT(forecast.window()->from_ns, at_ns + 3 * kFrameTime);
  EXPECT_GT(forecast.window()->until_ns, at_ns + 3 * kFrameTime);
}

TEST(ArrivalForecast, SurvivesFramesThatAllComeAtOnceAndOnesFromBefore) {
  ArrivalForecast forecast(kShare);
  for (int f = 0; f < 100; ++f) forecast.frame_came(kMs);
  EXPECT_FALSE(forecast.window());
  for (int f = 0; f < 100; ++f) forecast.frame_came(1000 * kMs - f * kMs);
  EXPECT_FALSE(forecast.window());
  feed(forecast, 100, 2000 * kMs);
  EXPECT_TRUE(forecast.window());
}

TEST(ArrivalForecast, LearnsARateThatFallsInWithTheOldOneNowAndThen) {
  for (const std::int64_t frame_time :
       {kFrameTime * 6 / 5, kFrameTime * 4 / 5, kFrameTime * 5 / 4, kFrameTime / 2, kFrameTime * 10, kFrameTime * 25}) {
    ArrivalForecast forecast(kShare);
    std::int64_t at_ns = feed(forecast, 100, kMs);
    for (int f = 0; f < 250; ++f) forecast.frame_came(at_ns += frame_time);
    ASSERT_TRUE(forecast.window()) << frame_time;
    EXPECT_GT(forecast.window()->until_ns, at_ns + frame_time);
    EXPECT_LT(forecast.window()->from_ns, at_ns + frame_time);
  }
}

TEST(ArrivalForecast, SleepsThroughFramesThatBeginToComeInPairs) {
  ArrivalForecast forecast(kShare);
  std::int64_t at_ns = feed(forecast, 100, kMs);
  for (int f = 0; f < 100; ++f) {
    forecast.frame_came(at_ns += kFrameTime);
    forecast.frame_came(at_ns + 10 * kUs);
  }
  EXPECT_FALSE(forecast.window());
}

TEST(ArrivalForecast, KeepsItsRhythmWhereEveryFifthFrameIsLost) {
  ArrivalForecast forecast(kShare);
  for (int f = 0; f < 1000; ++f) {
    if (f < 100 || f % 5 != 0) forecast.frame_came(kMs + f * kFrameTime);
  }
  EXPECT_GT(forecast.foreseen().value(), 600u - 50u);
}

TEST(ArrivalForecast, IsNotMisledByFramesThatWereLostWhileItLearnt) {
  ArrivalForecast forecast(kShare);
  for (int f = 0; f < 100; ++f) {
    if (f != 3 && f != 9) forecast.frame_came(kMs + f * kFrameTime);
  }
  EXPECT_GT(forecast.foreseen().value(), 50u);
}

TEST(ArrivalForecast, GoesOnAtAnotherPhaseAfterASilence) {
  ArrivalForecast forecast(kShare);
  const std::int64_t last_ns = feed(forecast, 100, kMs);
  const auto foreseen = forecast.foreseen().value();
  feed(forecast, 50, last_ns + 1000 * kFrameTime + kFrameTime / 2);
  EXPECT_EQ(forecast.missed().value(), 1u);
  EXPECT_EQ(forecast.foreseen().value(), foreseen + 49);
}

TEST(ArrivalForecast, NeverAsksForMoreThanTheShareNorForMoreThanTheCap) {
  for (const std::int64_t jitter_ns : {0L, 40 * kUs, 100 * kUs, 200 * kUs}) {
    ArrivalForecast forecast(kShare), generous(1);
    feed(forecast, 1000, kMs, jitter_ns);
    feed(generous, 1000, kMs, jitter_ns);
    if (forecast.window()) {
      EXPECT_LE(forecast.window()->until_ns - forecast.window()->from_ns, 251 * kUs) << jitter_ns;
    }
    ASSERT_TRUE(generous.window()) << jitter_ns;
    EXPECT_LE(generous.window()->until_ns - generous.window()->from_ns, 301 * kUs);
  }
}

TEST(ArrivalForecast, KnowsNothingAfterAReset) {
  ArrivalForecast forecast(kShare);
  feed(forecast, 100, kMs);
  forecast.reset();
  EXPECT_FALSE(forecast.window());
  forecast.frame_came(1000 * kMs);
  EXPECT_FALSE(forecast.window());
}

}  // namespace
}  // namespace risorius
