#include "daemon/watchdog.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(Watchdog, CallsAStreamStaleAfterThreeFrameTimesAndOnlyOnce) {
  Watchdog dog;
  dog.use_rate(100);
  EXPECT_FALSE(dog.look(1000 * kMs)) << "nothing has come yet";
  for (int f = 0; f < 50; ++f) EXPECT_FALSE(dog.frame_came(f * 10 * kMs));
  EXPECT_FALSE(dog.look(519 * kMs));
  EXPECT_EQ(dog.deadline_ns(), 520 * kMs);
  EXPECT_TRUE(dog.look(520 * kMs));
  EXPECT_TRUE(dog.stale());
  EXPECT_FALSE(dog.look(600 * kMs));
  EXPECT_EQ(dog.silences().value(), 1u);
  EXPECT_TRUE(dog.frame_came(700 * kMs));
  EXPECT_FALSE(dog.stale());
  EXPECT_FALSE(dog.look(729 * kMs)) << "the silence itself does not count as a frame time";
  EXPECT_TRUE(dog.look(730 * kMs));
}

TEST(Watchdog, GivesASlowlyPlayedStreamItsTime) {
  Watchdog dog;
  dog.use_rate(100);
  for (int f = 0; f < 100; ++f) {
    dog.frame_came(f * 25 * kMs);  // at 40 Hz
    if (f > 20) {
      EXPECT_FALSE(dog.look((f * 25 + 24) * kMs));
    }
  }
  EXPECT_EQ(dog.silences().value(), 0u);
}

TEST(Watchdog, LearnsTheRateThatNobodyStates) {
  Watchdog dog;
  dog.use_rate(0);
  for (int f = 0; f < 100; ++f) dog.frame_came(f * 20 * kMs);
  EXPECT_FALSE(dog.look(1980 * kMs + 59 * kMs));
  EXPECT_TRUE(dog.look(1980 * kMs + 61 * kMs));
}

TEST(Watchdog, RecoversFromABurstAtAnUnknownRate) {
  Watchdog dog;
  dog.use_rate(0);
  for (int f = 0; f < 50; ++f) dog.frame_came(f * kMs / 100);
  std::uint64_t silences = 0;
  for (int f = 1; f <= 200; ++f) {
    if (f == 100) silences = dog.silences().value();
    dog.look(f * 20 * kMs - kMs);
    dog.frame_came(f * 20 * kMs);
  }
  EXPECT_EQ(dog.silences().value(), silences) << "the frame time was never learnt again";
}

TEST(Watchdog, IsSilentAfterTheEndOfAStream) {
  Watchdog dog;
  dog.use_rate(1000);
  dog.frame_came(0);
  EXPECT_FALSE(dog.look(2 * kMs)) << "three frame times, but never less than 3 ms";
  dog.stream_ended();
  EXPECT_FALSE(dog.look(1000 * kMs));
  EXPECT_FALSE(dog.stale());
}

}  // namespace
}  // namespace risorius
