#include "capture/wire/reorder_window.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "capture/errors.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

using Sequences = std::vector<std::uint64_t>;

MarkerFrame frame_of(std::uint64_t sequence, std::int64_t start_ns = 0) {
  MarkerFrame frame;
  frame.header.sequence = sequence;
  frame.header.capture_time_ns = start_ns + static_cast<std::int64_t>(sequence) * 10'000'000;
  return frame;
}

Sequences pop_all(ReorderWindow& window) {
  Sequences popped;
  for (MarkerFrame frame; window.pop(frame);) popped.push_back(frame.header.sequence);
  return popped;
}

Sequences push(ReorderWindow& window, const Sequences& sequences, std::int64_t start_ns = 0) {
  Sequences popped;
  for (const auto sequence : sequences) {
    EXPECT_TRUE(window.push(frame_of(sequence, start_ns)));
    EXPECT_TRUE(window.ledger().balanced());
    for (const auto out : pop_all(window)) popped.push_back(out);
    EXPECT_TRUE(window.ledger().balanced());
  }
  return popped;
}

Sequences flush(ReorderWindow& window) {
  window.flush();
  const auto popped = pop_all(window);
  EXPECT_TRUE(window.ledger().balanced());
  EXPECT_EQ(window.ledger().held.value(), 0u);
  return popped;
}

TEST(ReorderWindow, PassesFramesInOrderAtOnce) {
  ReorderWindow window;
  for (std::uint64_t sequence = 100; sequence < 200; ++sequence)
    EXPECT_EQ(push(window, {sequence}), Sequences{sequence});
  EXPECT_EQ(window.lost().value(), 0u);
}

TEST(ReorderWindow, UndoesEveryPermutationWithinTheWindow) {
  std::mt19937 random(2);
  for (int round = 0; round < 50; ++round) {
    Sequences sent(400);
    std::iota(sent.begin(), sent.end(), 0);
    // No frame is displaced by more than 4: at most 4 can wait for one.
    for (std::size_t i = 1; i + 5 <= sent.size(); i += 5) {
      std::shuffle(sent.begin() + static_cast<std::ptrdiff_t>(i), sent.begin() + static_cast<std::ptrdiff_t>(i + 5),
                   random);
    }
    ReorderWindow window({.depth = 5});
    auto received = push(window, sent);
    for (const auto sequence : flush(window)) received.push_back(sequence);
    std::sort(sent.begin(), sent.end());
    EXPECT_EQ(received, sent);
    EXPECT_EQ(window.ledger().dropped.value(), 0u);
    EXPECT_EQ(window.lost().value(), 0u);
  }
}

TEST(ReorderWindow, WaitsForNothingWhereTheTransportKeepsTheOrder) {
  ReorderWindow window;
  EXPECT_EQ(push(window, {1, 2}), (Sequences{1, 2}));
  EXPECT_TRUE(window.push(frame_of(5)));
  window.give_up_gaps();
  EXPECT_EQ(pop_all(window), Sequences{5});
  EXPECT_EQ(window.lost().value(), 2u);
  EXPECT_TRUE(window.ledger().balanced());
  EXPECT_EQ(push(window, {6}), Sequences{6});
}

TEST(ReorderWindow, GivesAGapUpWhenDepthFramesWait) {
  ReorderWindow window({.depth = 3});
  EXPECT_EQ(push(window, {0, 1, 4, 5}), (Sequences{0, 1}));
  EXPECT_EQ(push(window, {7}), (Sequences{4, 5}));
  EXPECT_EQ(window.lost().value(), 2u);
  EXPECT_EQ(push(window, {6}), (Sequences{6, 7}));
}

TEST(ReorderWindow, GivesAGapUpWhenTicksSayThatTheTimeIsUp) {
  ReorderWindow window({.timeout_ns = 100});
  push(window, {0, 2});
  window.tick({.time_ns = 1000});
  window.tick({.time_ns = 1099});
  EXPECT_TRUE(pop_all(window).empty());
  window.tick({.time_ns = 1100});
  EXPECT_EQ(pop_all(window), Sequences{2});
  EXPECT_EQ(window.lost().value(), 1u);
  // A gap that closes takes its clock with it.
  push(window, {4});
  window.tick({.time_ns = 2000});
  EXPECT_EQ(push(window, {3}), (Sequences{3, 4}));
  push(window, {6});
  window.tick({.time_ns = 2100});
  EXPECT_TRUE(pop_all(window).empty());
  window.tick({.time_ns = 2200});
  EXPECT_EQ(pop_all(window), Sequences{6});
}

TEST(ReorderWindow, DropsAndCountsDuplicates) {
  ReorderWindow window;
  EXPECT_EQ(push(window, {0, 1, 1, 0, 3, 3, 2, 3}), (Sequences{0, 1, 2, 3}));
  EXPECT_EQ(window.duplicates().value(), 4u);
  EXPECT_EQ(window.ledger().dropped.value(), 4u);
  EXPECT_EQ(window.late().value(), 0u);
}

TEST(ReorderWindow, ALateFrameIsDroppedAndNoLongerLost) {
  ReorderWindow window({.depth = 1});
  EXPECT_EQ(push(window, {10, 12}), (Sequences{10, 12}));
  EXPECT_EQ(window.lost().value(), 1u);
  EXPECT_TRUE(push(window, {11}).empty());
  EXPECT_EQ(window.lost().value(), 0u);
  EXPECT_EQ(window.late().value(), 1u);
  EXPECT_TRUE(push(window, {11}).empty());
  EXPECT_EQ(window.duplicates().value(), 1u);
  // From before the stream began: late, but it was never counted as lost.
  EXPECT_TRUE(push(window, {9}).empty());
  EXPECT_EQ(window.late().value(), 2u);
  EXPECT_EQ(window.lost().value(), 0u);
}

TEST(ReorderWindow, EndOfStreamCountsTheMissingTail) {
  ReorderWindow window;
  push(window, {0, 1, 3});
  window.end_of_stream(9);
  EXPECT_EQ(pop_all(window), Sequences{3});
  EXPECT_EQ(window.lost().value(), 7u);  // 2 and 4 to 9
  push(window, {7});
  EXPECT_EQ(window.lost().value(), 6u);
  EXPECT_EQ(window.late().value(), 1u);
  EXPECT_EQ(window.restarts().value(), 0u);
  window.end_of_stream(9);
  window.end_of_stream(std::numeric_limits<std::uint64_t>::max() / 2);  // nonsense counts nothing
  EXPECT_EQ(window.lost().value(), 6u);
}

TEST(ReorderWindow, TakesAJumpFarBackForARestart) {
  ReorderWindow window({.restart_back_frames = 100});
  push(window, {1000, 1001, 1003});
  EXPECT_EQ(push(window, {0, 1}), (Sequences{1003, 0, 1}));
  EXPECT_EQ(window.restarts().value(), 1u);
  EXPECT_EQ(window.lost().value(), 1u);
}

TEST(ReorderWindow, TakesAJumpFarForwardForARestart) {
  ReorderWindow window;
  EXPECT_EQ(push(window, {5, 6, 5'000'000, 5'000'001}), (Sequences{5, 6, 5'000'000, 5'000'001}));
  EXPECT_EQ(window.restarts().value(), 1u);
  EXPECT_EQ(window.lost().value(), 0u);
}

TEST(ReorderWindow, TakesSequencesThatGoBackWhileTimeGoesOnForARestart) {
  ReorderWindow window;
  push(window, {0, 1, 2, 3});
  EXPECT_EQ(push(window, {0, 1, 2}, 1'000'000'000), (Sequences{0, 1, 2}));
  EXPECT_EQ(window.restarts().value(), 1u);
  EXPECT_EQ(window.ledger().dropped.value(), 0u);
}

TEST(ReorderWindow, AfterAFlushAnySequenceMayCome) {
  ReorderWindow window;
  push(window, {50, 52});
  EXPECT_EQ(flush(window), Sequences{52});
  EXPECT_EQ(push(window, {3, 4}), (Sequences{3, 4}));
  EXPECT_EQ(window.restarts().value(), 0u);
  EXPECT_EQ(window.lost().value(), 1u);
}

TEST(ReorderWindow, CountsOnAcrossTheEndOfTheNumbers) {
  constexpr auto kLast = std::numeric_limits<std::uint64_t>::max();
  ReorderWindow window;
  EXPECT_EQ(push(window, {kLast - 1, 0, kLast, 1}, 0).size(), 4u);
  EXPECT_EQ(window.restarts().value(), 0u);
}

TEST(ReorderWindow, RefusesAPushWhenFullAndLosesNothing) {
  ReorderWindow window({.depth = 2});
  ASSERT_TRUE(window.push(frame_of(0)));
  ASSERT_TRUE(window.push(frame_of(1)));
  EXPECT_FALSE(window.push(frame_of(2)));
  EXPECT_EQ(window.ledger().received.value(), 2u);
  EXPECT_EQ(pop_all(window), (Sequences{0, 1}));
  EXPECT_EQ(push(window, {2}), Sequences{2});
}

// Loss, duplicates and displacement at random: whatever happens, order and accounts hold.
TEST(ReorderWindow, HoldsItsLawsUnderChaos) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    constexpr std::uint64_t kFrames = 2000;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> arrivals;  // arrival, sequence
    for (std::uint64_t sequence = 1; sequence <= kFrames; ++sequence) {
      for (std::uint64_t copies = random() % 10 == 0 ? 0 : 1 + (random() % 10 == 0); copies > 0; --copies) {
        arrivals.emplace_back(4 * sequence + random() % (random() % 50 == 0 ? 100 : 20), sequence);
      }
    }
    std::sort(arrivals.begin(), arrivals.end());
    arrivals.insert(arrivals.begin(), {0, 0});  // a known first frame
    ReorderWindow window({.depth = 4});
    Sequences received;
    std::set<std::uint64_t> distinct;
    for (const auto& [arrival, sequence] : arrivals) {
      distinct.insert(sequence);
      for (const auto out : push(window, {sequence})) received.push_back(out);
      window.tick({.time_ns = static_cast<std::int64_t>(arrival) * 2'500'000});
      for (const auto out : pop_all(window)) received.push_back(out);
    }
    window.end_of_stream(kFrames);
    for (const auto out : flush(window)) received.push_back(out);
    EXPECT_TRUE(std::is_sorted(received.begin(), received.end()));
    EXPECT_EQ(std::adjacent_find(received.begin(), received.end()), received.end());
    EXPECT_EQ(window.lost().value(), kFrames + 1 - distinct.size());  // exactly those that never arrived
    EXPECT_EQ(received.size() + window.late().value(), distinct.size());
    EXPECT_EQ(window.ledger().dropped.value(), window.late().value() + window.duplicates().value());
    EXPECT_GT(window.late().value(), 0u);
    EXPECT_EQ(window.restarts().value(), 0u);
  }
}

bool equal(const MarkerFrame& a, const MarkerFrame& b) {
  return a.header.sequence == b.header.sequence && a.header.stream_id == b.header.stream_id &&
         a.header.capture_time_ns == b.header.capture_time_ns && a.header.receive_time_ns == b.header.receive_time_ns &&
         a.count == b.count && a.state == b.state && a.reason == b.reason && a.position_mm == b.position_mm &&
         a.standard_deviation_mm == b.standard_deviation_mm;
}

TEST(ReorderWindow, HandsFramesOnUnchangedAndAlikeEveryTime) {
  std::vector<MarkerFrame> sent;
  for (const std::uint64_t sequence : {0, 2, 1, 1, 6, 5, 9, 3, 7}) {
    MarkerFrame frame = frame_of(sequence);
    frame.header.stream_id = 7;
    frame.header.receive_time_ns = static_cast<std::int64_t>(100 - sequence);
    frame.count = kMaxMarkers;
    for (std::size_t i = 0; i < kMaxMarkers; ++i) {
      frame.state[i] = static_cast<MarkerState>((sequence + i) % 4);
      frame.reason[i] = static_cast<RejectReason>((sequence + i) % 7);
      frame.position_mm[i] = {static_cast<float>(sequence), static_cast<float>(i), 1};
      frame.standard_deviation_mm[i] = static_cast<float>(sequence + i);
    }
    sent.push_back(frame);
  }
  std::vector<MarkerFrame> first;
  for (int round = 0; round < 2; ++round) {
    ReorderWindow window({.depth = 3});
    std::vector<MarkerFrame> received;
    MarkerFrame frame;
    for (const auto& in : sent) {
      ASSERT_TRUE(window.push(in));
      while (window.pop(frame)) received.push_back(frame);
    }
    window.flush();
    while (window.pop(frame)) received.push_back(frame);
    ASSERT_EQ(received.size(), 7u);  // 0 to 2; 5, 6 when 9 made three that wait; 7, 9; but 3 came too late
    for (const auto& out : received) {
      const auto same = [&out](const MarkerFrame& in) { return equal(in, out); };
      EXPECT_TRUE(std::any_of(sent.begin(), sent.end(), same)) << out.header.sequence;
    }
    if (round == 0) first = received;
    EXPECT_TRUE(std::equal(first.begin(), first.end(), received.begin(), received.end(), equal));
  }
}

TEST(ReorderWindow, AStragglerAfterTheEndIsLateAndWhatGoesOnIsANewStream) {
  ReorderWindow window;
  MarkerFrame frame;
  const auto push = [&](std::uint64_t sequence) {
    EXPECT_TRUE(window.push(frame_of(sequence)));
    std::size_t released = 0;
    while (window.pop(frame)) ++released;
    return released;
  };
  for (const std::uint64_t sequence : {0, 1, 2, 3}) EXPECT_EQ(push(sequence), 1u);
  window.end_of_stream(6);
  EXPECT_EQ(window.lost().value(), 3u);
  EXPECT_EQ(push(5), 0u);
  EXPECT_EQ(window.late().value(), 1u);
  EXPECT_EQ(window.lost().value(), 2u);
  EXPECT_EQ(push(5), 0u);
  EXPECT_EQ(push(2), 0u);
  EXPECT_EQ(window.duplicates().value(), 2u);
  EXPECT_EQ(push(9), 1u);  // it goes on: what is missing before is of no stream
  EXPECT_EQ(window.lost().value(), 2u);
  EXPECT_EQ(push(11), 0u);  // and waits for 10 again
  window.flush();
  while (window.pop(frame)) {
  }
  EXPECT_EQ(window.lost().value(), 3u);
  EXPECT_EQ(window.restarts().value(), 0u);
  EXPECT_TRUE(window.ledger().balanced());
}

TEST(ReorderWindow, AllocatesNothing) {
  ReorderWindow window;
  MarkerFrame frame;
  const auto before = test::allocations_of_this_thread();
  for (const std::uint64_t sequence : {0, 2, 1, 5, 9, 7, 4, 4, 100, 90, 1'000'000, 3}) {
    window.push(frame_of(sequence));
    window.tick({.time_ns = static_cast<std::int64_t>(sequence) * 10'000'000});
    while (window.pop(frame)) {
    }
  }
  window.end_of_stream(20);
  window.flush();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(ReorderWindow, NamesOptionsOutOfRange) {
  EXPECT_THROW(ReorderWindow({.depth = 0}), UserError);
  EXPECT_THROW(ReorderWindow({.depth = 65}), UserError);
  EXPECT_THROW(ReorderWindow({.timeout_ns = 0}), UserError);
  EXPECT_THROW(ReorderWindow({.restart_back_frames = 8}), UserError);
  EXPECT_THROW(ReorderWindow({.restart_forward_frames = 8}), UserError);
}

}  // namespace
}  // namespace risorius
