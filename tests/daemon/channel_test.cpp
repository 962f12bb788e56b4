#include "daemon/channel.h"

#include <gtest/gtest.h>
#include <thread>

#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

TEST(Channel, KeepsRoomForControlItemsWhenFramesFillIt) {
  Channel<int> channel(64);
  int accepted = 0;
  while (channel.send_frame(accepted)) ++accepted;
  EXPECT_EQ(accepted, 64);
  EXPECT_EQ(channel.refused_frames(), 1u);
  EXPECT_TRUE(channel.send_control(-1));
  EXPECT_EQ(channel.refused_control(), 0u);
  for (int i = 0; i < accepted; ++i) {
    ASSERT_NE(channel.front(), nullptr);
    EXPECT_EQ(*channel.front(), i);
    channel.release();
  }
  EXPECT_EQ(*channel.front(), -1) << "in the order in which they were sent";
}

TEST(Channel, WakesASleepingConsumerForEveryItem) {
  constexpr int kItems = 20'000;
  Channel<int> channel(64);
  std::jthread producer([&] {
    for (int i = 0; i < kItems;) {
      if (channel.send_frame(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  int expected = 0;
  while (expected < kItems) {
    while (const int* item = channel.front()) {
      ASSERT_EQ(*item, expected++);
      channel.release();
    }
    if (expected < kItems) channel.wait();
  }
}

TEST(Channel, AnAnnouncedItemIsWaitedForAndOneThatNeverComesIsNot) {
  Channel<int> channel(64);
  channel.announce();
  channel.wait();  // comes back although nothing follows
  EXPECT_EQ(channel.front(), nullptr);
  channel.announce();
  std::jthread producer([&] { channel.send_frame(7); });
  while (channel.front() == nullptr) channel.wait();
  EXPECT_EQ(*channel.front(), 7);
}

TEST(Channel, IsAwakeForAnAnnouncedItemUntilTheAnnouncedTimeAndNotOnceMoreAfterIt) {
  constexpr std::int64_t kLong = 3'600'000'000'000;
  Channel<int> channel(64);
  channel.announce(monotonic_now_ns() + kLong);
  channel.announce(monotonic_now_ns() - 1);  // of another source, and over: the first one stands
  std::jthread producer([&] { channel.send_frame(7); });
  channel.wait();  // comes back with the item, not with the hour
  ASSERT_NE(channel.front(), nullptr);
  channel.release();
  producer.join();
  channel.ring();
  channel.wait();
  EXPECT_EQ(channel.front(), nullptr);
}

}  // namespace
}  // namespace risorius
