#include "replay/live/pacer.h"

#include <gtest/gtest.h>
#include <limits>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

constexpr std::int64_t kStart = 5'000'000'000;

TEST(Pacer, DeadlinesFollowCaptureTimesFromTheFirstFrameOn) {
  for (const double speed : {0.25, 1.0, 2.0, 16.0}) {
    Pacer pacer({.speed = speed});
    for (std::int64_t i = 0; i < 1000; ++i) {
      const std::int64_t capture_time_ns = 777 + i * 16'666'667;
      const double expected = static_cast<double>(kStart) + static_cast<double>(i * 16'666'667) / speed;
      // However late the calls come, no deadline moves.
      const std::int64_t now_ns = kStart + 3 * i * 16'666'667;
      EXPECT_NEAR(static_cast<double>(pacer.deadline_ns(capture_time_ns, now_ns)), expected, 0.5);
    }
  }
}

TEST(Pacer, StartsAnewWhenCaptureTimesJump) {
  Pacer pacer({.longest_gap_ns = 1'000'000'000});
  pacer.deadline_ns(0, kStart);
  EXPECT_EQ(pacer.deadline_ns(900'000'000, kStart), kStart + 900'000'000);
  EXPECT_EQ(pacer.deadline_ns(2'000'000'000, kStart + 5), kStart + 5);
  EXPECT_EQ(pacer.deadline_ns(1'000'000'000, kStart + 9), kStart + 9);
  EXPECT_EQ(pacer.deadline_ns(1'000'000'100, kStart + 9), kStart + 109);
  EXPECT_EQ(pacer.deadline_ns(std::numeric_limits<std::int64_t>::min(), kStart + 20), kStart + 20);
  EXPECT_EQ(pacer.deadline_ns(std::numeric_limits<std::int64_t>::max(), kStart + 30), kStart + 30);
}

TEST(Pacer, WithoutASpeedKeepsToTheCapAndMakesUpForNoLostTime) {
  Pacer pacer({.speed = 0, .frame_cap_hz = 1000});
  EXPECT_EQ(pacer.deadline_ns(0, kStart), kStart);
  EXPECT_EQ(pacer.deadline_ns(0, kStart), kStart + 1'000'000);
  EXPECT_EQ(pacer.deadline_ns(0, kStart), kStart + 2'000'000);
  EXPECT_EQ(pacer.deadline_ns(0, kStart + 9'000'000), kStart + 9'000'000);
  EXPECT_EQ(pacer.deadline_ns(0, kStart + 9'000'000), kStart + 10'000'000);
  Pacer unbounded({.speed = 0});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(unbounded.deadline_ns(i, kStart), kStart);
}

TEST(Pacer, CountsLateFrames) {
  Pacer pacer({.late_after_ns = 100});
  pacer.record(kStart, kStart - 5);
  pacer.record(kStart, kStart + 100);
  pacer.record(kStart, kStart + 350);
  EXPECT_EQ(pacer.statistics().frames, 3u);
  EXPECT_EQ(pacer.statistics().late_frames, 1u);
  EXPECT_EQ(pacer.statistics().max_lateness_ns, 350);
}

TEST(Pacer, NeverLetsAFrameGoEarly) {
  Pacer pacer;
  const std::int64_t before_ns = monotonic_now_ns();
  for (std::int64_t i = 0; i <= 5; ++i) {
    ASSERT_TRUE(pacer.wait(i * 1'000'000));
    EXPECT_GE(monotonic_now_ns(), before_ns + i * 1'000'000);
  }
  EXPECT_EQ(pacer.statistics().frames, 6u);
}

TEST(Pacer, NamesOptionsOutOfRange) {
  EXPECT_THROW(Pacer({.speed = -1}), UserError);
  EXPECT_THROW(Pacer({.speed = 1e-9}), UserError);
  EXPECT_THROW(Pacer({.speed = std::numeric_limits<double>::quiet_NaN()}), UserError);
  EXPECT_THROW(Pacer({.frame_cap_hz = -1}), UserError);
  EXPECT_THROW(Pacer({.late_after_ns = -1}), UserError);
  EXPECT_THROW(Pacer({.longest_gap_ns = 0}), UserError);
}

}  // namespace
}  // namespace risorius
