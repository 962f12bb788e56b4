#include "capture/wire/live_link_session.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "capture/errors.h"
#include "capture/frame_words.h"
#include "support/allocation_counter.h"
#include "support/live_link_packets.h"

namespace risorius {
namespace {

using test::HandLiveLink;

struct Fed {
  explicit Fed(const LiveLinkOptions& options = {}) : session(options) {}
  void push(const HandLiveLink& hand) {
    session.push(hand.bytes(), 1000 + static_cast<std::int64_t>(frames.size()));
    for (SourceEvent event; session.pop(event);) {
      if (event.kind == SourceEventKind::kNewSession) ++sessions;
      if (event.kind == SourceEventKind::kMarkerSet) sets.push_back(event.set);
      if (event.kind == SourceEventKind::kShapes) frames.push_back(event.shapes);
    }
    EXPECT_TRUE(session.counters().datagrams.balanced());
    EXPECT_TRUE(session.counters().frames.balanced());
  }
  std::uint64_t refused(LiveLinkRefusal reason) const { return session.counters().of(reason); }
  std::vector<std::uint64_t> sequences() const {
    std::vector<std::uint64_t> numbers;
    for (const ShapeFrame& frame : frames) numbers.push_back(frame.header.sequence);
    return numbers;
  }
  LiveLinkSession session;
  int sessions = 0;
  std::vector<const MarkerSet*> sets;
  std::vector<ShapeFrame> frames;
};

using Numbers = std::vector<std::uint64_t>;

TEST(LiveLinkSession, HandsOnASessionItsRateAndTheFrame) {
  Fed fed({.stream_id = 4});
  fed.push({.frame = 216'061, .subframe = 0.5F});  // one hour, one second and one frame at 60 frames/s
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.sessions, 1);
  ASSERT_EQ(fed.sets.size(), 1u);
  EXPECT_TRUE(fed.sets[0]->names.empty());
  EXPECT_EQ(fed.sets[0]->rate_hz, 60);
  const FrameHeader& header = fed.frames[0].header;
  EXPECT_EQ(header.stream_id, 4u);
  EXPECT_EQ(header.set_id, fed.sets[0]->id);
  EXPECT_EQ(header.receive_time_ns, 1000);
  EXPECT_EQ(header.capture_time_ns, std::llround(216'061.5 / 60 * 1e9));
  EXPECT_EQ(text_of(header.timecode), "01:00:01:01");
  EXPECT_TRUE(fed.frames[0].has_face);
  EXPECT_EQ(fed.frames[0].value[51], 51.0F / 64);
}

TEST(LiveLinkSession, AFrameWithoutAFaceIsAFrame) {
  Fed fed;
  fed.push({.has_count = false});
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_FALSE(fed.frames[0].has_face);
}

TEST(LiveLinkSession, ValuesThatNoShapeCanHaveAreNotTold) {
  Fed fed;
  HandLiveLink hand;
  hand.values[0] = 2.5F;
  hand.values[1] = -0.3F;
  hand.values[2] = 1.003F;  // occurs
  fed.push(hand);
  EXPECT_TRUE(std::isnan(fed.frames[0].value[0]) && std::isnan(fed.frames[0].value[1]));
  EXPECT_EQ(fed.frames[0].value[2], 1.003F);
  EXPECT_EQ(fed.session.counters().extras[1].counter->value(), 2u);
}

TEST(LiveLinkSession, NumbersAFrameByTheFrameTimesThatFitBetween) {
  Fed fed;
  // 59.94 frames/s counted in a base of 60: one step of 2 now and then, and no frame is lost.
  double time = 100.6;
  for (int i = 0; i < 2000; ++i, time += 60 * 1001.0 / 60000) {
    const double whole = std::floor(time);
    fed.push({.frame = static_cast<std::int32_t>(whole), .subframe = static_cast<float>(time - whole)});
  }
  ASSERT_EQ(fed.frames.size(), 2000u);
  const std::uint64_t first = fed.frames.front().header.sequence;
  for (std::size_t i = 0; i < 2000; ++i) ASSERT_EQ(fed.frames[i].header.sequence, first + i);
  fed.push({.frame = fed.frames.size() ? static_cast<std::int32_t>(time) + 4 : 0, .subframe = 0});
  EXPECT_EQ(fed.frames.back().header.sequence, first + 2000 + 3);  // a hole; the time was at .6 of a frame
}

TEST(LiveLinkSession, LateAndRepeatedPacketsKeepTheirNumbers) {
  Fed fed;
  for (const int frame : {10, 11, 13, 12, 13, 14}) fed.push({.frame = frame});
  EXPECT_EQ(fed.sequences(), (Numbers{10, 11, 13, 12, 13, 14}));
}

TEST(LiveLinkSession, ARateGivenByTheUserIsTheStepInAFinerBase) {
  Fed fed({.rate_hz = 30});
  for (const int frame : {100, 102, 104, 108}) fed.push({.frame = frame});
  EXPECT_EQ(fed.sequences(), (Numbers{50, 51, 52, 54}));
  EXPECT_EQ(fed.sets[0]->rate_hz, 30);
}

TEST(LiveLinkSession, MidnightIsAFrameLikeAnother) {
  struct Base {
    std::int32_t fps, denominator, last_frame;
  };
  // 24 h of 60 frames/s; of 29.97 with the drop-frame count, and with all numbers counted.
  for (const Base base : {Base{60, 1, 5'183'999}, Base{30000, 1001, 2'589'407}, Base{30000, 1001, 2'591'999}}) {
    Fed fed;
    for (const int offset : {-1, 0})
      fed.push({.frame = base.last_frame + offset, .fps = base.fps, .denominator = base.denominator});
    for (const int frame : {0, 2, 1}) fed.push({.frame = frame, .fps = base.fps, .denominator = base.denominator});
    const auto last = static_cast<std::uint64_t>(base.last_frame);
    EXPECT_EQ(fed.sequences(), (Numbers{last - 1, last, last + 1, last + 3, last + 2}));
    EXPECT_EQ(fed.sessions, 1);
    EXPECT_GT(fed.frames[2].header.capture_time_ns, fed.frames[1].header.capture_time_ns);
    EXPECT_EQ(text_of(fed.frames[2].header.timecode).substr(0, 8), "00:00:00");
  }
}

TEST(LiveLinkSession, AStragglerFromBeforeMidnightIsLate) {
  Fed fed;
  for (const int frame : {5'183'998, 0, 5'183'999, 1}) fed.push({.frame = frame});
  EXPECT_EQ(fed.sequences(), (Numbers{5'183'998, 5'184'000, 5'183'999, 5'184'001}));
}

TEST(LiveLinkSession, ADeviceThatStartsOverIsANewSession) {
  for (const int restart : {3, 500'000}) {
    Fed fed;
    for (const int frame : {1000, 1001}) fed.push({.frame = frame});
    for (const int frame : {restart, restart + 1, restart + 2}) fed.push({.frame = frame});
    EXPECT_EQ(fed.sessions, 2);
    EXPECT_EQ(fed.refused(LiveLinkRefusal::kLeap), 1u);
    const auto first = static_cast<std::uint64_t>(restart);
    EXPECT_EQ(fed.sequences(), (Numbers{1000, 1001, first + 1, first + 2}));
  }
}

TEST(LiveLinkSession, OnePacketFromAnotherTimeEndsNothing) {
  Fed fed;
  for (const int frame : {1000, 1001, 3, 1002, 1003, 400'000, 1004}) fed.push({.frame = frame});
  EXPECT_EQ(fed.sessions, 1);
  EXPECT_EQ(fed.refused(LiveLinkRefusal::kLeap), 2u);
  EXPECT_EQ(fed.sequences(), (Numbers{1000, 1001, 1002, 1003, 1004}));
}

TEST(LiveLinkSession, AnotherRateIsANewSessionWithItsOwnSet) {
  Fed fed;
  fed.push({.frame = 1000});
  fed.push({.frame = 500, .fps = 30});
  fed.push({.frame = 1001});
  EXPECT_EQ(fed.sessions, 3);
  ASSERT_EQ(fed.sets.size(), 3u);
  EXPECT_EQ(fed.sets[1]->rate_hz, 30);
  EXPECT_EQ(fed.sets[0], fed.sets[2]);
}

TEST(LiveLinkSession, ASenderOfEverNewRatesIsRefusedAfterSome) {
  Fed fed;
  for (int fps = 1; fps <= 200; ++fps) fed.push({.fps = fps});
  EXPECT_EQ(fed.frames.size(), 64u);
  EXPECT_EQ(fed.refused(LiveLinkRefusal::kRates), 136u);
}

TEST(LiveLinkSession, ListensToTheFirstDeviceOrToTheGivenOne) {
  for (const std::string wanted : {"", "B"}) {
    Fed fed({.device = wanted});
    for (int frame = 0; frame < 3; ++frame) {
      fed.push({.name = "A", .frame = frame});
      fed.push({.name = "B", .frame = 100 + frame});
    }
    EXPECT_EQ(fed.sequences(), wanted.empty() ? (Numbers{0, 1, 2}) : (Numbers{100, 101, 102}));
    EXPECT_EQ(fed.refused(LiveLinkRefusal::kOtherDevice), 3u);
  }
}

TEST(LiveLinkSession, DropFrameTimecodeLeavesTheFirstNumbersOfAMinuteOut) {
  EXPECT_EQ(text_of(live_link_timecode(1799, 30000, 1001)), "00:00:59;29");
  EXPECT_EQ(text_of(live_link_timecode(1800, 30000, 1001)), "00:01:00;02");
  EXPECT_EQ(text_of(live_link_timecode(17982, 30000, 1001)), "00:10:00;00");
  EXPECT_EQ(text_of(live_link_timecode(2'589'407, 30000, 1001)), "23:59:59;29");
  EXPECT_EQ(text_of(live_link_timecode(3600, 60000, 1001)), "00:01:00;04");
  EXPECT_EQ(text_of(live_link_timecode(1440, 24000, 1001)), "00:01:00:00");
  EXPECT_EQ(text_of(live_link_timecode(5'183'999, 60, 1)), "23:59:59:59");
}

TEST(LiveLinkSession, AllocatesNothingOnceItKnowsTheRate) {
  LiveLinkSession session;
  std::vector<std::vector<std::byte>> packets;
  for (int frame = 0; frame < 50; ++frame) packets.push_back(HandLiveLink{.frame = frame}.bytes());
  SourceEvent event;
  session.push(packets[0], 1);
  while (session.pop(event)) {
  }
  const std::uint64_t before = test::allocations_of_this_thread();
  for (const auto& packet : packets) {
    session.push(packet, 1);
    while (session.pop(event)) {
    }
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_EQ(session.counters().frames.emitted.value(), 51u);
}

TEST(LiveLinkSession, MutatedPacketsNeverUpsetTheLedgers) {
  std::mt19937 random(7);
  LiveLinkSession session;
  SourceEvent event;
  for (int round = 0; round < 20'000; ++round) {
    auto bytes = HandLiveLink{.frame = round}.bytes();
    for (int change = 0; change < 2; ++change) bytes[random() % 80] = static_cast<std::byte>(random() % 256);
    session.push(bytes, round);
    while (session.pop(event)) {
    }
  }
  EXPECT_TRUE(session.counters().datagrams.balanced());
  EXPECT_TRUE(session.counters().frames.balanced());
  EXPECT_EQ(session.counters().datagrams.received.value(), 20'000u);
}

TEST(LiveLinkSession, WrongOptionsAreTheUsersToSolve) {
  EXPECT_THROW(LiveLinkSession({.rate_hz = 0.5}), UserError);
  EXPECT_THROW(LiveLinkSession({.rate_hz = 1001}), UserError);
  EXPECT_THROW(LiveLinkSession({.device = std::string(256, 'x')}), UserError);
}

}  // namespace
}  // namespace risorius
