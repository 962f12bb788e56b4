#include "capture/clock_sync.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kOffset = 123'456'789'012'345;

/// When our clock shows the tracker's time, if ours runs `ppm` millionths faster.
std::int64_t ours(std::int64_t tracker_ns, double ppm) {
  return kOffset + tracker_ns + std::llround(static_cast<double>(tracker_ns) * ppm * 1e-6);
}

/// Frames at 120 Hz for so many seconds, each 2 ms late and more by an exponential of mean 1 ms.
void arrive(ClockSync& sync, double ppm, int seconds, std::int64_t from_ns = 0) {
  std::mt19937 random(1);
  std::exponential_distribution<double> jitter(1e-6);
  for (int f = 0; f < 120 * seconds; ++f) {
    const std::int64_t capture_ns = from_ns + f * kSecond / 120;
    sync.add_arrival(capture_ns, ours(capture_ns, ppm) + 2'000'000 + std::llround(jitter(random)));
  }
}

TEST(ClockSync, FindsOffsetAndSkewUnderJitteryArrivals) {
  for (const double ppm : {-80.0, 0.0, 35.0}) {
    ClockSync sync;
    EXPECT_FALSE(sync.known());
    arrive(sync, ppm, 40);
    ASSERT_TRUE(sync.known());
    EXPECT_FALSE(sync.has_echo());
    EXPECT_NEAR(sync.skew_ppm(), ppm, 2);  // 0.05 ms of jitter's minimum over 40 s
    // The offset holds the smallest delay of the way, which nobody can tell from it.
    const std::int64_t now = 40 * kSecond;
    EXPECT_NEAR(static_cast<double>(sync.to_ours_ns(now) - ours(now, ppm)), 2e6, 1e5) << ppm;
  }
}

TEST(ClockSync, PrefersEchoesAndKeepsTheShortestRoundTrips) {
  ClockSync sync;
  arrive(sync, 20, 3);
  std::mt19937 random(2);
  std::exponential_distribution<double> wait(1e-6);
  for (int i = 0; i < 200; ++i) {
    const std::int64_t tracker_ns = 3 * kSecond + i * kSecond / 5;
    // Out and back take 0.1 ms and more, each by its own.
    const std::int64_t out = 100'000 + std::llround(wait(random)), back = 100'000 + std::llround(wait(random));
    sync.add_echo(ours(tracker_ns, 20) - out, tracker_ns, ours(tracker_ns, 20) + back);
  }
  EXPECT_TRUE(sync.has_echo());
  EXPECT_NEAR(sync.skew_ppm(), 20, 10);
  const std::int64_t now = 43 * kSecond;
  EXPECT_NEAR(static_cast<double>(sync.to_ours_ns(now) - ours(now, 20)), 0, 3e5);
  EXPECT_LT(sync.uncertainty_ns(), 400'000);
  EXPECT_GE(sync.uncertainty_ns(), 100'000);
}

TEST(ClockSync, BeginsAnewWhenTheTrackersClockLeaps) {
  ClockSync sync;
  arrive(sync, 10, 20);
  arrive(sync, 10, 20, 1'000'000 * kSecond);  // arrivals of another clock: they go on in ours
  const std::int64_t offset = sync.offset_ns();
  for (int f = 0; f < 1200; ++f) {
    const std::int64_t capture_ns = f * kSecond / 120;  // the tracker begins at 0 again
    sync.add_arrival(capture_ns, 2 * kOffset + capture_ns);
  }
  EXPECT_GE(sync.leaps().value(), 1u);
  EXPECT_NE(sync.offset_ns(), offset);
  EXPECT_EQ(sync.offset_ns(), 2 * kOffset);
}

TEST(ClockSync, NoticesALeapAheadBeforeItKnowsTheSlope) {
  for (const std::int64_t leap_ns : {kSecond / 2, 60 * kSecond, 3600 * kSecond}) {
    ClockSync sync;
    arrive(sync, 0, 1);
    for (int f = 0; f < 120; ++f) {
      const std::int64_t time_ns = kSecond + f * kSecond / 120;
      sync.add_arrival(time_ns + leap_ns, ours(time_ns, 0));
    }
    EXPECT_EQ(sync.leaps().value(), 1u) << leap_ns;
    EXPECT_EQ(sync.offset_ns(), kOffset - leap_ns);
  }
}

TEST(ClockSync, NoticesAClockSetBackByASecondWhenItStaysBehind) {
  ClockSync sync;
  arrive(sync, 0, 20);
  for (int f = 0; f < 120; ++f) {
    const std::int64_t time_ns = 20 * kSecond + f * kSecond / 120;
    sync.add_arrival(time_ns - kSecond / 2, ours(time_ns, 0));
  }
  EXPECT_EQ(sync.leaps().value(), 1u);
  EXPECT_EQ(sync.offset_ns(), kOffset + kSecond / 2);
}

TEST(ClockSync, TakesNoPacketThatIsLateOrWasOvertakenForALeap) {
  ClockSync sync;
  for (int f = 0; f < 1200; ++f) {
    const std::int64_t time_ns = f * kSecond / 120;
    // Every 400 frames one is held up for 2 s, and those behind it are lost until it came; then one is overtaken.
    const int place = f % 400;
    if (place > 100 && place < 340) continue;
    sync.add_arrival(time_ns, ours(time_ns + (place == 100 ? 2 * kSecond : 0), 0));
    if (place == 350) sync.add_arrival(time_ns - kSecond / 2, ours(time_ns, 0));
  }
  EXPECT_EQ(sync.leaps().value(), 0u);
  EXPECT_EQ(sync.offset_ns(), kOffset);
}

TEST(ClockSync, FollowsATakePlayedAtAnotherPace) {
  ClockSync sync;
  for (int f = 0; f < 60 * 200; ++f) sync.add_arrival(f * kSecond / 60, kOffset + f * kSecond / 600);
  EXPECT_EQ(sync.leaps().value(), 0u);
  EXPECT_NEAR(sync.skew_ppm(), -900'000, 100);
}

TEST(ClockSync, SurvivesTimesFromAnywhereAndThenFindsTheTruth) {
  ClockSync sync;
  for (const std::int64_t time : {INT64_MIN, INT64_MAX, std::int64_t{0}, std::int64_t{-1}, INT64_MAX, INT64_MIN}) {
    sync.add_arrival(time, 5);
    sync.add_arrival(5, time);
    EXPECT_TRUE(std::isfinite(sync.skew_ppm()));
  }
  arrive(sync, 20, 40, 1000 * kSecond);
  ASSERT_TRUE(sync.known());
  EXPECT_NEAR(sync.skew_ppm(), 20, 2);
  const std::int64_t now = 1040 * kSecond;
  EXPECT_NEAR(static_cast<double>(sync.to_ours_ns(now) - ours(now, 20)), 2e6, 1e5);
}

TEST(ClockSync, RefusesEchoesThatAreNone) {
  ClockSync sync;
  sync.add_echo(INT64_MIN, 5, INT64_MAX);
  sync.add_echo(5, INT64_MAX, 6);
  sync.add_echo(6, 5, 5);              // back before it left
  sync.add_echo(0, 5, 100 * kSecond);  // nobody waits for so long
  EXPECT_FALSE(sync.known());
  EXPECT_FALSE(sync.has_echo());
}

}  // namespace
}  // namespace risorius
