#include "capture/spsc_queue.h"

#include <gtest/gtest.h>
#include <thread>

namespace risorius {
namespace {

TEST(SpscQueue, RefusesWhenFullAndCountsIt) {
  SpscQueue<int> queue(4);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.try_push(i));
  EXPECT_FALSE(queue.try_push(4));
  EXPECT_EQ(queue.refused(), 1u);
  int value = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(queue.try_pop(value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(queue.try_pop(value));
  EXPECT_EQ(queue.high_water(), 4u);
}

TEST(SpscQueue, KeepsOrderBetweenTwoThreads) {
  constexpr int kCount = 50'000;
  SpscQueue<int> queue(64);
  std::jthread producer([&] {
    for (int i = 0; i < kCount;) {
      if (queue.try_push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  int expected = 0, value = 0;
  while (expected < kCount) {
    if (!queue.try_pop(value)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(value, expected);
    ++expected;
  }
  EXPECT_EQ(queue.pushed(), queue.popped());
}

}  // namespace
}  // namespace risorius
