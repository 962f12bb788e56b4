#include "daemon/record_ring.h"

#include <gtest/gtest.h>
#include <random>
#include <string>
#include <thread>

namespace risorius {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

std::string text_of(const RecordRing::Record& record) {
  return {reinterpret_cast<const char*>(record.payload.data()), record.payload.size()};
}

TEST(RecordRing, GivesBackWhatWasPushedInOrder) {
  RecordRing ring(4096);
  EXPECT_FALSE(ring.front(ring.end()));
  ASSERT_TRUE(ring.try_push({.kind = 3, .stream = 2, .sequence = 9, .time_ns = 77}, bytes_of("from "), bytes_of("me")));
  ASSERT_TRUE(ring.try_push({.kind = 4}, {}));
  const auto first = ring.front(ring.end());
  ASSERT_TRUE(first);
  EXPECT_EQ(first->head.kind, 3);
  EXPECT_EQ(first->head.stream, 2);
  EXPECT_EQ(first->head.sequence, 9u);
  EXPECT_EQ(first->head.time_ns, 77);
  EXPECT_EQ(text_of(*first), "from me");
  ring.release(*first);
  const auto second = ring.front(ring.end());
  ASSERT_TRUE(second);
  EXPECT_EQ(second->head.kind, 4);
  EXPECT_EQ(text_of(*second), "");
  ring.release(*second);
  EXPECT_FALSE(ring.front(ring.end()));
  EXPECT_EQ(ring.size(), 0u);
}

TEST(RecordRing, ReadsOnlyUpToTheMark) {
  RecordRing ring(4096);
  ASSERT_TRUE(ring.try_push({.kind = 1}, bytes_of("a")));
  const std::size_t mark = ring.end();
  ASSERT_TRUE(ring.try_push({.kind = 1}, bytes_of("b")));
  ring.release(*ring.front(mark));
  EXPECT_FALSE(ring.front(mark));
  EXPECT_EQ(text_of(*ring.front(ring.end())), "b");
}

TEST(RecordRing, RefusesWhatFindsNoRoomAndKeepsTheReserveFree) {
  RecordRing ring(4096);
  const std::string large(3000, 'x');
  ASSERT_TRUE(ring.try_push({.kind = 1}, bytes_of(large)));
  EXPECT_FALSE(ring.try_push({.kind = 1}, bytes_of(large)));
  EXPECT_FALSE(ring.try_push({.kind = 1}, bytes_of("small"), {}, 1048)) << "not into what is kept free";
  EXPECT_TRUE(ring.try_push({.kind = 1}, bytes_of("small")));
  EXPECT_FALSE(RecordRing(4096).try_push({.kind = 1}, bytes_of(std::string(5000, 'x')))) << "larger than the ring";
}

TEST(RecordRing, TwoThreadsAgreeOnEveryByteWhateverTheLengths) {
  RecordRing ring(1 << 14);
  constexpr std::uint32_t kRecords = 50'000;
  std::thread producer([&ring] {
    std::mt19937 random(3);
    for (std::uint32_t i = 0; i < kRecords; ++i) {
      const std::string payload(random() % 700, static_cast<char>('a' + i % 26));
      while (!ring.try_push({.kind = 1, .sequence = i}, bytes_of(payload))) std::this_thread::yield();
    }
  });
  std::mt19937 random(3);
  std::uint32_t next = 0;
  bool equal = true;
  while (next < kRecords) {
    const auto record = ring.front(ring.end());
    if (!record) {
      std::this_thread::yield();
      continue;
    }
    const std::string expected(random() % 700, static_cast<char>('a' + next % 26));
    equal = equal && record->head.sequence == next && text_of(*record) == expected;
    ring.release(*record);
    ++next;
  }
  producer.join();
  EXPECT_TRUE(equal);
  EXPECT_LE(ring.high_water(), ring.capacity());
}

}  // namespace
}  // namespace risorius
