#include "capture/wire/vicon_session.h"

#include <cstring>
#include <gtest/gtest.h>
#include <random>

#include "capture/wire/vicon_packet_writer.h"
#include "support/allocation_counter.h"
#include "support/hex.h"
#include "support/session_events.h"

namespace risorius {
namespace {

using test::balanced;
using test::events_of;
using test::hex;
using test::kinds_of;
using test::said_by;
using test::operator+;
using Bytes = std::vector<std::byte>;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kPeriod120 = 1125000;  // 135e6 / 120

template <class Write>
Bytes packet(Write write) {
  ByteAppender out;
  ViconPacketWriter writer(out);
  write(writer);
  writer.finish();
  return {out.bytes().begin(), out.bytes().end()};
}

Bytes greeting(std::vector<std::uint32_t> ids = {1, 2, 5, 6, 7, 23, 26, 37, 39, 40, 42, 100004}) {
  return packet([&](auto& p) { p.ids(ViconId::kObjectEnums, ids); });
}
const ViconSubject kFace{.id = 7, .name = "face", .markers = {{10, "chin"}, {11, "nose"}}};
const ViconSubject kHand{.id = 8, .name = "hand", .markers = {{10, "thumb"}}};
const ViconRecon kChin{7, 10, {1, 2, 3}}, kNose{7, 11, {4, 5, 6}};

struct Frame {
  std::uint32_t number = 0;
  std::vector<ViconRecon> recons{kChin, kNose};
  std::vector<ViconSubject> subjects{kFace};
  std::int64_t period = kPeriod120;
  std::optional<bool> y_up = false;
};

Bytes frame(const Frame& f) {
  return packet([&](auto& p) {
    if (f.period > 0) p.i64(ViconId::kStreamInfo, f.period);
    for (const auto& subject : f.subjects) p.subject(subject);
    if (f.y_up) p.u8(ViconId::kApplicationInfo, *f.y_up ? 1 : 0);
    p.u32(ViconId::kFrameInfo, f.number);
    p.labelled(f.recons);
  });
}

struct Talk {
  explicit Talk(const ViconSessionOptions& options = {}) : session(options) { session.connected(now_ns); }
  std::vector<SourceEvent> hear(const Bytes& bytes) {
    EXPECT_EQ(session.receive(bytes, now_ns), bytes.size());
    EXPECT_TRUE(balanced(session));
    return events_of(session);
  }
  std::vector<SourceEvent> hear(const Frame& f) { return hear(frame(f)); }
  std::int64_t now_ns = 1000 * kSecond;
  ViconSession session;
};

TEST(ViconSession, AsksForWhatIsOfferedAndForPush) {
  Talk talk;
  EXPECT_TRUE(said_by(talk.session).empty()) << "nothing before the greeting";
  talk.hear(greeting({2, 5, 6, 99}));
  // Three ids: 2, 5, 6, then the push of PROTOCOLS.md.
  EXPECT_EQ(said_by(talk.session), hex("01002B1A 18000000 A1860100 10000000 03000000 02000000 05000000 06000000"
                                       "01002B1A 09000000 A2860100 01000000 01"));
  talk.hear(greeting({2, 5, 6, 99}));
  EXPECT_TRUE(said_by(talk.session).empty());
  talk.hear(greeting({5}));
  EXPECT_EQ(said_by(talk.session), hex("01002B1A 10000000 A1860100 08000000 01000000 05000000"));
}

TEST(ViconSession, NamesMarkersAndPlacesThem) {
  Talk talk;
  talk.hear(greeting());
  const auto events = talk.hear(Frame{.number = 12});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"chin", "nose"}));
  EXPECT_EQ(events[1].set->rate_hz, 120);
  EXPECT_EQ(events[1].set->axes.letters(), "FLU");
  EXPECT_EQ(events[2].frame.header.sequence, 12u);
  EXPECT_EQ(events[2].frame.header.capture_time_ns, 100'000'000);  // 12 / 120 Hz
  EXPECT_EQ(events[2].frame.header.receive_time_ns, talk.now_ns);
  EXPECT_EQ(events[2].frame.position_mm[1], (Position{5, 6, 4}));  // front 4, left 5, up 6
  EXPECT_EQ(talk.session.counters().link, LinkState::kStreaming);
}

TEST(ViconSession, TakesPacketsInAnyOrder) {
  // Frames before the greeting, records before the names in the same packet.
  Talk talk;
  const std::vector<ViconRecon> recons{kNose};
  const auto events = talk.hear(packet([&](auto& p) {
    p.labelled(recons);
    p.u32(ViconId::kFrameInfo, 1);
    p.subject(kFace);
    p.i64(ViconId::kStreamInfo, kPeriod120);
  }));
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[2].frame.state[0], MarkerState::kMissing);
  EXPECT_EQ(events[2].frame.state[1], MarkerState::kMeasured);
  talk.hear(greeting());
  EXPECT_FALSE(said_by(talk.session).empty());
}

TEST(ViconSession, TakesAMarkerWithoutARecordForOccluded) {
  Talk talk;
  talk.hear(greeting());
  EXPECT_EQ(talk.hear(Frame{.number = 1, .recons = {kNose}})[2].frame.state[0], MarkerState::kMissing);
  const auto none = talk.hear(Frame{.number = 2, .recons = {}});
  ASSERT_EQ(kinds_of(none), "F");
  EXPECT_EQ(none[0].frame.state[1], MarkerState::kMissing);
  // Records in another order mean the same.
  const auto turned = talk.hear(Frame{.number = 3, .recons = {kNose, kChin}});
  EXPECT_EQ(turned[0].frame.position_mm[0], (Position{2, 3, 1}));
}

TEST(ViconSession, KeepsRecordsThatAreUnchanged) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1, .recons = {kChin}});
  const std::array<std::uint32_t, 1> unchanged{6};
  const auto events = talk.hear(packet([&](auto& p) {
    p.contents({}, unchanged);
    p.u32(ViconId::kFrameInfo, 2);
  }));
  ASSERT_EQ(kinds_of(events), "F");
  EXPECT_EQ(events[0].frame.header.sequence, 2u);
  EXPECT_EQ(events[0].frame.state[0], MarkerState::kMeasured);
  EXPECT_EQ(events[0].frame.position_mm[0], (Position{2, 3, 1}));
  EXPECT_EQ(events[0].frame.state[1], MarkerState::kMissing);
  // Absent and not unchanged: nothing is known, which is not "all occluded".
  EXPECT_EQ(kinds_of(talk.hear(packet([](auto& p) { p.u32(ViconId::kFrameInfo, 3); }))), "");
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kNoMarkers), 1u);
  // Unchanged since a connection that is gone.
  talk.session.disconnected();
  talk.session.connected(talk.now_ns);
  EXPECT_EQ(kinds_of(talk.hear(packet([&](auto& p) {
              p.contents({}, unchanged);
              p.u32(ViconId::kFrameInfo, 4);
            }))),
            "E");
}

TEST(ViconSession, CountsRecordsThatNobodyDescribed) {
  Talk talk;
  talk.hear(greeting());
  const auto events = talk.hear(Frame{.number = 1, .recons = {kChin, {7, 99, {1, 1, 1}}, {9, 10, {1, 1, 1}}}});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(talk.session.vicon_counters().unlabelled_markers.value(), 2u);
  // And those that the server itself has no name for: one record of 108 bytes.
  talk.hear(hex("01002B1A 8C000000 05000000 04000000 02000000 07000000 70000000 01000000") + Bytes(108) +
            hex("06000000 00000000"));
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kBadLength), 1u) << "6 without a count";
  talk.hear(hex("01002B1A 90000000 05000000 04000000 02000000 07000000 70000000 01000000") + Bytes(108) +
            hex("06000000 04000000 00000000"));
  EXPECT_EQ(talk.session.vicon_counters().unlabelled_markers.value(), 3u);
}

TEST(ViconSession, TakesTheFirstOfADuplicate) {
  Talk talk;
  talk.hear(greeting());
  const auto events = talk.hear(Frame{.number = 1, .recons = {kChin, {7, 10, {9, 9, 9}}}});
  EXPECT_EQ(events[2].frame.position_mm[0], (Position{2, 3, 1}));
}

TEST(ViconSession, MakesPositionsThatAreNoNumbersMissing) {
  Talk talk;
  talk.hear(greeting());
  const auto events = talk.hear(Frame{
      .number = 1, .recons = {{7, 10, {1, std::numeric_limits<double>::quiet_NaN(), 3}}, {7, 11, {1e300, 2, 3}}}});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[2].frame.state[0], MarkerState::kMissing);
  EXPECT_EQ(events[2].frame.state[1], MarkerState::kMissing) << "no float reaches so far";
  EXPECT_EQ(talk.session.counters().not_finite_markers.value(), 2u);
}

TEST(ViconSession, TellsSeveralSubjectsApart) {
  Talk all;
  all.hear(greeting());
  const Frame both{.number = 1, .recons = {kChin, {8, 10, {7, 8, 9}}}, .subjects = {kFace, kHand}};
  const auto events = all.hear(both);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"face:chin", "face:nose", "hand:thumb"}));
  EXPECT_EQ(events[2].frame.position_mm[2], (Position{8, 9, 7}));
  Talk one({.subject = "hand"});
  one.hear(greeting());
  const auto chosen = one.hear(both);
  ASSERT_EQ(kinds_of(chosen), "NSF");
  EXPECT_EQ(chosen[1].set->names, (std::vector<std::string>{"thumb"}));
  Talk absent({.subject = "foot"});
  absent.hear(greeting());
  EXPECT_EQ(kinds_of(absent.hear(both)), "");
  EXPECT_EQ(absent.session.counters().of(ViconRefusal::kNoNames), 1u);
}

TEST(ViconSession, MapsNamesAgainWhenSubjectsChange) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1});
  const ViconSubject renamed{.id = 7, .name = "face", .markers = {{11, "chin"}, {10, "nose"}}};
  const auto events = talk.hear(Frame{.number = 2, .subjects = {renamed}});
  ASSERT_EQ(kinds_of(events), "F") << "the same names: the same set";
  EXPECT_EQ(events[0].frame.position_mm[0], (Position{5, 6, 4})) << "chin has id 11 now";
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 3, .subjects = {kFace, kHand}})), "SF");
  // Without static objects they stay as they are.
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 4, .subjects = {}, .period = 0, .y_up = {}})), "F");
}

TEST(ViconSession, WhateverTheMarkersAreCalledTheSetIsOne) {
  Talk talk;
  talk.hear(greeting());
  const ViconSubject odd{.id = 7, .name = "face", .markers = {{10, "chin"}, {11, "chin"}, {12, ""}, {13, "M\xe4rker"}}};
  const auto events = talk.hear(Frame{.number = 1, .subjects = {odd}});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_TRUE(problems_of(*events[1].set).empty()) << problems_of(*events[1].set).front();
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"chin", "chin#2", "3", "M\xc3\xa4rker"}));
  EXPECT_EQ(events[2].frame.state[1], MarkerState::kMeasured);
}

TEST(ViconSession, MoreMarkersThanAFrameHoldsAreARefusalOfTheirOwn) {
  Talk talk;
  talk.hear(greeting());
  ViconSubject many{.id = 7, .name = "face", .markers = {}};
  for (std::uint32_t i = 0; i <= kMaxMarkers; ++i) many.markers.push_back({i, "m" + std::to_string(i)});
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 1, .subjects = {many}})), "");
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kTooManyMarkers), 1u);
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kBadNames), 0u);
  // The same subjects come with every frame.
  talk.hear(Frame{.number = 2, .subjects = {many}});
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kTooManyMarkers), 2u);
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kNoNames), 0u);
  // Of the same name 100,000 times (which took minutes to tell apart) no more is read than it takes to refuse them.
  ViconSubject alike{.id = 7, .name = "face", .markers = {}};
  for (std::uint32_t i = 0; i < 100'000; ++i) alike.markers.push_back({i, "a"});
  talk.hear(Frame{.number = 3, .subjects = {alike}});
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kTooManyMarkers), 3u);
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 4})), "NSF");
}

TEST(ViconSession, APeriodOfNoRateIsNotStated) {
  Talk talk;
  talk.hear(greeting());
  for (const std::int64_t period : {std::int64_t{1}, std::int64_t{1} << 60}) {
    const auto events = talk.hear(Frame{.number = 1, .period = period});
    if (!events.empty()) {
      ASSERT_EQ(kinds_of(events), "NSF");
      EXPECT_EQ(events[1].set->rate_hz, 0);
      EXPECT_EQ(events[2].frame.header.capture_time_ns, talk.now_ns);
    }
  }
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kBadNames), 0u);
  EXPECT_EQ(talk.session.counters().frames.received.value(), 1u);  // the second is of the same number
}

TEST(ViconSession, TurnsYUpWorlds) {
  Talk talk;
  talk.hear(greeting());
  const auto events = talk.hear(Frame{.number = 1, .y_up = true});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->axes.letters(), "FUR");
  EXPECT_EQ(events[2].frame.position_mm[0], (Position{-3, 2, 1}));  // front 1, up 2, right 3
  // The same point told with Z up, by PROTOCOLS.md: (x, y, z) -> (x, -z, y).
  const auto z_up = talk.hear(Frame{.number = 2, .recons = {{7, 10, {1, -3, 2}}}});
  ASSERT_EQ(kinds_of(z_up), "SF");
  EXPECT_EQ(z_up[1].frame.position_mm[0], (Position{-3, 2, 1}));
}

TEST(ViconSession, CarriesDropFrameTimecode) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1});
  const std::vector<ViconRecon> recons{kChin};
  const auto events = talk.hear(packet([&](auto& p) {
    p.u32(ViconId::kFrameInfo, 2);
    p.timecode(Timecode{10, 59, 58, 29, 30, true});
    p.labelled(recons);
  }));
  ASSERT_EQ(kinds_of(events), "F");
  const Timecode& timecode = events[0].frame.header.timecode;
  EXPECT_EQ(timecode.hours, 10);
  EXPECT_EQ(timecode.frames, 29);
  EXPECT_EQ(timecode.frame_rate, 30);
  EXPECT_TRUE(timecode.drop_frame);
}

TEST(ViconSession, TakesAFrameNumberThatGoesBackForARestart) {
  Talk talk;
  talk.hear(greeting());
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 100})), "NSF");
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 100})), "") << "the same once more";
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 150})), "F");
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 149})), "NSF");
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = kViconNoFrame})), "") << "no data";
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 150})), "F");
}

TEST(ViconSession, BeginsANewSessionWithANewRate) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 100});
  const auto events = talk.hear(Frame{.number = 101, .period = 1350000});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->rate_hz, 100);
  EXPECT_EQ(events[2].frame.header.capture_time_ns, 1'010'000'000);
}

TEST(ViconSession, WorksWithAServerThatStatesNoRate) {
  Talk stated({.rate_hz = 50});
  stated.hear(greeting({2, 5, 6}));
  const auto events = stated.hear(Frame{.number = 10, .period = 0, .y_up = {}});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->rate_hz, 50);
  EXPECT_EQ(events[2].frame.header.capture_time_ns, 200'000'000);
  Talk unstated;
  unstated.hear(greeting({2, 5, 6}));
  const auto arrived = unstated.hear(Frame{.number = 10, .period = 0, .y_up = {}});
  EXPECT_EQ(arrived[2].frame.header.capture_time_ns, unstated.now_ns);
  EXPECT_EQ(unstated.session.vicon_counters().arrival_times.value(), 1u);
}

TEST(ViconSession, MeasuresTheRoundTrip) {
  Talk talk;
  talk.hear(greeting());
  said_by(talk.session);
  talk.now_ns += 2 * kSecond;
  talk.session.tick(talk.now_ns);
  const Bytes ping = said_by(talk.session);
  EXPECT_EQ(ping, hex("01002B1A 10000000 2A000000 08000000 0100000000000000"));
  talk.now_ns += 350'000;
  talk.hear(ping);
  EXPECT_EQ(talk.session.vicon_counters().round_trip_us.value(), 350u);
  ASSERT_TRUE(talk.session.last_ping());
  EXPECT_EQ(talk.session.last_ping()->received_ns - talk.session.last_ping()->sent_ns, 350'000);
  talk.hear(hex("01002B1A 10000000 2A000000 08000000 6300000000000000"));
  EXPECT_EQ(talk.session.vicon_counters().round_trip_us.value(), 350u) << "not ours";
}

TEST(ViconSession, TellsTheServersLatency) {
  Talk talk;
  talk.hear(greeting());
  const std::vector<ViconRecon> recons{kChin};
  const std::array<std::pair<std::string_view, double>, 2> latencies{{{"a", 0.002}, {"b", 0.0015}}};
  talk.hear(packet([&](auto& p) {
    p.subject(kFace);
    p.u32(ViconId::kFrameInfo, 2);
    p.latencies(latencies);
    p.labelled(recons);
  }));
  EXPECT_EQ(talk.session.vicon_counters().latency_us.value(), 3500u);
}

TEST(ViconSession, GivesUpServersThatAreNoneOrDead) {
  Talk silent;
  silent.session.tick(silent.now_ns + 6 * kSecond);
  EXPECT_TRUE(silent.session.failed());
  Talk other;
  other.session.receive(hex("48545450 2F312E31"), 0);
  EXPECT_TRUE(other.session.failed());
  EXPECT_EQ(other.session.counters().of(ViconRefusal::kBadTag), 1u);
  Talk huge;
  huge.session.receive(hex("01002B1A FFFFFF7F"), 0);
  EXPECT_TRUE(huge.session.failed());
  EXPECT_EQ(huge.session.counters().of(ViconRefusal::kTooLong), 1u);
  // One that never answered a Ping may be silent; one that did may not.
  Talk old;
  old.hear(greeting());
  for (int i = 1; i < 20; ++i) old.session.tick(old.now_ns + i * kSecond);
  EXPECT_FALSE(old.session.failed());
  Talk dead;
  dead.hear(greeting());
  said_by(dead.session);
  dead.session.tick(dead.now_ns += kSecond);
  dead.hear(said_by(dead.session));
  dead.session.tick(dead.now_ns + 6 * kSecond);
  EXPECT_TRUE(dead.session.failed());
}

TEST(ViconSession, RefusesAPacketWithAnObjectThatIsTooShortAndGoesOn) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(hex("01002B1A 0B000000 05000000 03000000 010203"));
  talk.hear(hex("01002B1A 0B000000 05000000 04000000 010203"));
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kBadLength), 1u);
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kBadObject), 1u);
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 1})), "NSF");
}

TEST(ViconSession, EndsTheStreamWithTheConnection) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1});
  talk.session.disconnected();
  EXPECT_EQ(kinds_of(talk.session), "E");
  EXPECT_EQ(talk.session.counters().link, LinkState::kLost);
}

TEST(ViconSession, WhatIsConnectedToAnewMustNameItsMarkersItself) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1});
  talk.session.disconnected();
  events_of(talk.session);
  talk.session.connected(talk.now_ns);
  talk.hear(greeting());
  EXPECT_EQ(kinds_of(talk.hear(Frame{.number = 1, .subjects = {}})), "");
  EXPECT_EQ(talk.session.counters().of(ViconRefusal::kNoNames), 1u);
  // The ids of before, and other names.
  const ViconSubject other{.id = 7, .name = "face", .markers = {{10, "nose"}, {11, "chin"}}};
  const auto events = talk.hear(Frame{.number = 2, .subjects = {other}});
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"nose", "chin"}));
}

Bytes whole_conversation() {
  Bytes all = greeting();
  for (std::uint32_t number = 1; number < 5; ++number) all = all + frame({.number = number});
  return all + hex("01002B1A 00000000");
}

TEST(ViconSession, GivesTheSameEventsHoweverTheStreamIsCut) {
  const Bytes all = whole_conversation();
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    ViconSession session({});
    session.connected(0);
    std::size_t used = session.receive(std::span(all).first(cut), 0);
    used += session.receive(std::span(all).subspan(used), 0);
    ASSERT_EQ(used, all.size());
    ASSERT_EQ(kinds_of(session), "NSFFFF") << cut;
  }
}

TEST(ViconSession, SurvivesMutatedConversations) {
  const Bytes good = whole_conversation();
  std::mt19937_64 random(24);
  std::size_t frames = 0, failures = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    for (std::uint64_t changes = 1 + random() % 5; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 3 == 0 ? 0xFF : random());
    ViconSession session({.tracker = {.event_capacity = 32}});
    session.connected(0);
    session.receive(bytes, 0);
    session.tick(static_cast<std::int64_t>(random() % 10) * kSecond);
    session.disconnected();
    failures += session.failed() ? 1 : 0;
    for (const auto& one : events_of(session)) frames += one.kind == SourceEventKind::kFrame ? 1 : 0;
    ASSERT_TRUE(balanced(session));
  }
  EXPECT_GT(frames, 1000u);
  EXPECT_GT(failures, 100u);
}

TEST(ViconSession, AllocatesNothingPerFrame) {
  Talk talk;
  talk.hear(greeting());
  talk.hear(Frame{.number = 1});
  std::vector<Bytes> frames;
  for (std::uint32_t number = 2; number < 50; ++number) frames.push_back(frame({.number = number}));
  SourceEvent popped;
  const auto before = test::allocations_of_this_thread();
  for (const Bytes& bytes : frames) {
    talk.session.receive(bytes, 0);
    while (talk.session.pop(popped)) {
    }
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_EQ(popped.frame.header.sequence, 49u);
}

}  // namespace
}  // namespace risorius
