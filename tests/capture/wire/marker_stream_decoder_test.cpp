#include "capture/wire/marker_stream_decoder.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "capture/errors.h"
#include "support/allocation_counter.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

using test::Bytes;
using test::datagram_of;
using test::datagrams_of;
using test::marker_frame;
using test::marker_set;
using test::same_markers;
using Kind = SourceEventKind;
constexpr std::int64_t kHold = MarkerStreamDecoder::kSessionHoldNs;

std::vector<SourceEvent> pop_all(MarkerStreamDecoder& decoder) {
  std::vector<SourceEvent> events;
  for (SourceEvent event; decoder.pop(event);) events.push_back(event);
  return events;
}

std::vector<SourceEvent> push_all(MarkerStreamDecoder& decoder, const std::vector<Bytes>& datagrams,
                                  std::int64_t receive_time_ns = 5) {
  std::vector<SourceEvent> events;
  for (const auto& datagram : datagrams) {
    EXPECT_TRUE(decoder.push(datagram, receive_time_ns));
    EXPECT_TRUE(decoder.counters().datagrams.balanced());
    EXPECT_TRUE(decoder.counters().frames.balanced());
    for (auto& event : pop_all(decoder)) events.push_back(event);
  }
  return events;
}

std::vector<Kind> kinds(const std::vector<SourceEvent>& events) {
  std::vector<Kind> kinds;
  for (const auto& event : events) kinds.push_back(event.kind);
  return kinds;
}

void expect_settled(MarkerStreamDecoder& decoder) {
  decoder.flush();
  pop_all(decoder);
  EXPECT_TRUE(decoder.counters().datagrams.balanced());
  EXPECT_TRUE(decoder.counters().frames.balanced());
  EXPECT_EQ(decoder.counters().datagrams.held.value(), 0u);
  EXPECT_EQ(decoder.counters().frames.held.value(), 0u);
}

TEST(MarkerStreamDecoder, GivesSessionSetFramesAndEnd) {
  MarkerStreamDecoder decoder({.stream_id = 9});
  const MarkerFrame sent = marker_frame(4, 60);
  auto events = push_all(decoder, datagrams_of(marker_set(60), 77));
  ASSERT_EQ(kinds(events), (std::vector{Kind::kNewSession, Kind::kMarkerSet}));
  EXPECT_EQ(events[0].session, 77u);
  EXPECT_EQ(*events[1].set, marker_set(60));
  events = push_all(decoder, datagrams_of(sent, 77));
  ASSERT_EQ(kinds(events), (std::vector{Kind::kFrame}));
  EXPECT_TRUE(same_markers(events[0].frame, sent));
  EXPECT_EQ(events[0].frame.header.stream_id, 9u);
  EXPECT_EQ(events[0].frame.header.receive_time_ns, 5);
  events = push_all(decoder, {datagram_of({77, 1, 4}), datagram_of({77, 1, 4}), datagram_of({77, 1, 4})});
  ASSERT_EQ(kinds(events), (std::vector{Kind::kEndOfStream}));
  EXPECT_EQ(events[0].end.last_sequence, 4u);
  EXPECT_EQ(decoder.counters().datagrams.dropped.value(), 2u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, PutsSplitFramesTogetherInAnyOrder) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(256)));
  std::array<std::size_t, 3> order{0, 1, 2};
  std::uint64_t sequence = 0;
  do {
    const MarkerFrame sent = marker_frame(++sequence, 256);
    const auto parts = datagrams_of(sent);
    ASSERT_EQ(parts.size(), order.size());  // ceil(256 / 117)
    const auto events = push_all(decoder, {parts[order[0]], parts[order[1]], parts[order[2]]});
    ASSERT_EQ(events.size(), 1u);
    EXPECT_TRUE(same_markers(events[0].frame, sent));
  } while (std::next_permutation(order.begin(), order.end()));
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ALostPartLosesExactlyItsFrame) {
  MarkerStreamDecoder decoder({.reassembly_frames = 3});
  push_all(decoder, datagrams_of(marker_set(200)));
  std::vector<std::uint64_t> received;
  for (std::uint64_t sequence = 0; sequence < 20; ++sequence) {
    auto parts = datagrams_of(marker_frame(sequence, 200));
    if (sequence == 5 || sequence == 6) parts.erase(parts.begin());
    for (const auto& event : push_all(decoder, parts)) received.push_back(event.frame.header.sequence);
  }
  EXPECT_EQ(received.size(), 18u);
  EXPECT_FALSE(std::count(received.begin(), received.end(), 5u) + std::count(received.begin(), received.end(), 6u));
  EXPECT_EQ(decoder.counters().incomplete_frames.value(), 2u);
  EXPECT_EQ(decoder.counters().datagrams.dropped.value(), 2u);  // the parts of them that did arrive
  // The lost part comes at last: too late, and it must not open the frame again.
  push_all(decoder, {datagrams_of(marker_frame(5, 200)).front()});
  expect_settled(decoder);
  EXPECT_EQ(decoder.counters().incomplete_frames.value(), 2u);
}

TEST(MarkerStreamDecoder, DropsRepeatedParts) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(200)));
  const auto parts = datagrams_of(marker_frame(1, 200));
  EXPECT_EQ(push_all(decoder, {parts[0], parts[0], parts[1], parts[1], parts[0]}).size(), 1u);
  EXPECT_EQ(decoder.counters().datagrams.dropped.value(), 3u);
  EXPECT_EQ(decoder.counters().frames.received.value(), 1u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, RefusesFramesBeforeTheirSet) {
  MarkerStreamDecoder decoder;
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(1, 10))).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kUnknownSet), 1u);
  push_all(decoder, datagrams_of(marker_set(10, 1)));
  EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(1, 10))).size(), 1u);
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(2, 10, 2))).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kUnknownSet), 2u);
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(2, 11))).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kCountMismatch), 1u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ARepeatedSetIsNoEventAndAChangedOneIs) {
  MarkerStreamDecoder decoder;
  const auto first = push_all(decoder, datagrams_of(marker_set(10)));
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_set(10))).empty());
  // The same id with other names: a redefinition. The first one stays readable.
  const auto second = push_all(decoder, datagrams_of(marker_set(10, 1, "other"), 1, 1));
  ASSERT_EQ(kinds(second), (std::vector{Kind::kMarkerSet}));
  EXPECT_EQ(second[0].set->names[3], "other3");
  EXPECT_EQ(first[1].set->names[3], "marker3");
  // A further id does not end the first.
  EXPECT_EQ(kinds(push_all(decoder, datagrams_of(marker_set(4, 2)))), (std::vector{Kind::kMarkerSet}));
  EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(1, 10))).size(), 1u);
  EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(2, 4, 2))).size(), 1u);
  // Back to the first definition: an event, and the same object as before.
  const auto third = push_all(decoder, datagrams_of(marker_set(10), 1, 2));
  ASSERT_EQ(third.size(), 1u);
  EXPECT_EQ(third[0].set, first[1].set);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ARedefinitionGivesUpFramesThatWereBegunUnderTheOldSet) {
  MarkerStreamDecoder decoder;
  MarkerSet set = marker_set(200);
  push_all(decoder, datagrams_of(set));
  const auto parts = datagrams_of(marker_frame(1, 200));
  push_all(decoder, {parts[0]});
  set.axes = *Axes::parse("FLU");
  push_all(decoder, datagrams_of(set, 1, 1));
  EXPECT_TRUE(push_all(decoder, {parts[1]}).empty());
  EXPECT_EQ(decoder.counters().incomplete_frames.value(), 1u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, NeverMixesTwoDefinitionsOfASplitSet) {
  MarkerStreamDecoder decoder;
  const auto a = datagrams_of(marker_set(256, 1, "a_rather_long_name_"), 1, 0);
  const auto b = datagrams_of(marker_set(256, 1, "b_rather_long_name_"), 1, 1);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 2u);
  std::vector<Bytes> mixed{a.begin(), a.end() - 1};
  mixed.push_back(b.back());
  EXPECT_TRUE(push_all(decoder, mixed).empty());
  EXPECT_EQ(push_all(decoder, b).size(), 2u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ANewSessionForgetsTheSetsInForce) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(10), 1));
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(1, 10), 2)).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kOtherSession), 1u);
  EXPECT_EQ(kinds(push_all(decoder, datagrams_of(marker_set(10, 7), 2), 5 + kHold)),
            (std::vector{Kind::kNewSession, Kind::kMarkerSet}));
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(1, 10, 1), 2)).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kUnknownSet), 1u);
  EXPECT_TRUE(push_all(decoder, {datagram_of({1, 5, 4})}).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kOtherSession), 2u);
  EXPECT_EQ(decoder.counters().sessions.value(), 2u);
}

TEST(MarkerStreamDecoder, TwoSendersOnOnePortDoNotTakeItFromEachOther) {
  MarkerStreamDecoder decoder;
  constexpr std::int64_t kPeriod = kHold / 20;
  std::uint64_t frames = 0, refused = 0;
  for (std::int64_t i = 0; i < 200; ++i) {
    for (std::uint32_t session = 1; session <= 3; ++session) {
      auto datagrams = datagrams_of(marker_frame(static_cast<std::uint64_t>(i), 10), session);
      if (i % 50 == 0) datagrams.insert(datagrams.begin(), datagrams_of(marker_set(10), session).at(0));
      for (const auto& event : push_all(decoder, datagrams, i * kPeriod)) {
        EXPECT_EQ(event.session, 1u);
        frames += event.kind == Kind::kFrame ? 1 : 0;
      }
      if (session != 1) refused += datagrams.size();
    }
  }
  EXPECT_EQ(frames, 200u);
  EXPECT_EQ(decoder.counters().sessions.value(), 1u);
  EXPECT_EQ(decoder.counters().of(DecodeError::kOtherSession), refused);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, AKilledAndRestartedSenderGoesOnWithItsFirstFrameAfterTheHold) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(10), 1), 0);
  push_all(decoder, datagrams_of(marker_frame(1, 10), 1), 10);
  // Its sets come at once and not again before a second has gone by; one of them is never used.
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_set(10), 2), 20).empty());
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_set(4, 2), 2), 20).empty());
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(0, 10), 2), 9 + kHold).empty());
  const auto events = push_all(decoder, datagrams_of(marker_frame(1, 10), 2), 10 + kHold);
  ASSERT_EQ(kinds(events), (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame}));
  EXPECT_EQ(events[2].session, 2u);
  EXPECT_EQ(*events[1].set, marker_set(10));
  // No frame comes before the event of its set: the other one waits for its repetition.
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(2, 4, 2), 2), 11 + kHold).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kUnknownSet), 1u);
  EXPECT_EQ(kinds(push_all(decoder, datagrams_of(marker_set(4, 2), 2), 12 + kHold)), (std::vector{Kind::kMarkerSet}));
  EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(3, 4, 2), 2), 13 + kHold).size(), 1u);
  // The first one is back within the hold: now it is the one that waits.
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(2, 10), 1), 14 + kHold).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kOtherSession), 4u);
  EXPECT_EQ(decoder.counters().sessions.value(), 2u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, AfterTheEndOfASessionTheNextBeginsAtOnceUnlessTheOldOneGoesOn) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(10), 1));
  push_all(decoder, datagrams_of(marker_frame(1, 10), 1));
  push_all(decoder, {datagram_of({1, 1, 1})});
  push_all(decoder, datagrams_of(marker_frame(2, 10), 1));  // a sender that goes on after its end
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_set(10), 2)).empty());
  push_all(decoder, {datagram_of({1, 2, 2})});
  push_all(decoder, datagrams_of(marker_frame(1, 10), 1));  // a late one is no going on
  EXPECT_EQ(kinds(push_all(decoder, datagrams_of(marker_frame(1, 10), 2))),
            (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame}));
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ASplitSetThatBeginsWithinTheHoldAndIsCompletedAfterItIsAccountedOnce) {
  MarkerStreamDecoder decoder;
  const auto own = datagrams_of(marker_set(256, 1, "a_rather_long_name_"), 1);
  const auto parts = datagrams_of(marker_set(256, 1, "b_rather_long_name_"), 2);
  ASSERT_GT(parts.size(), 2u);
  push_all(decoder, own, 0);
  push_all(decoder, {own[0], parts[0]}, 10);
  EXPECT_TRUE(push_all(decoder, {parts.begin() + 1, parts.end()}, 10 + kHold).empty());
  const auto events = push_all(decoder, {parts[0]}, 10 + kHold);
  ASSERT_EQ(kinds(events), (std::vector{Kind::kNewSession, Kind::kMarkerSet}));
  EXPECT_EQ(events[1].set->names[200], "b_rather_long_name_200");
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, HearsASenderThatStatesAnotherRateEachTimeItStarts) {
  MarkerStreamDecoder decoder;
  for (std::uint32_t session = 1; session <= 200; ++session) {
    MarkerSet set = marker_set(3, 1);
    set.rate_hz = 59.9 + 1e-4 * session;
    push_all(decoder, datagrams_of(set, session), session * kHold);
    EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(1, 3, 1), session), session * kHold).size(), 1u) << session;
  }
  EXPECT_EQ(decoder.counters().of(DecodeError::kTooManySets), 0u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, HasAtMost64SetsInForce) {
  MarkerStreamDecoder decoder;
  for (std::uint32_t id = 0; id < 70; ++id) push_all(decoder, datagrams_of(marker_set(3, id)));
  EXPECT_EQ(decoder.counters().sets_changed.value(), 64u);
  EXPECT_EQ(decoder.counters().of(DecodeError::kTooManySets), 6u);
  EXPECT_EQ(push_all(decoder, datagrams_of(marker_frame(1, 3, 63))).size(), 1u);
  EXPECT_TRUE(push_all(decoder, datagrams_of(marker_frame(1, 3, 64))).empty());
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, RefusesASetThatNamesAMarkerTwice) {
  MarkerStreamDecoder decoder;
  EXPECT_TRUE(push_all(decoder, datagrams_of(MarkerSet{.id = 1, .names = {"a", "b", "a"}})).empty());
  EXPECT_EQ(decoder.counters().of(DecodeError::kBadSet), 1u);
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, ConvertsToMillimetresAndOurAxesUnlessOverridden) {
  MarkerSet set = marker_set(1);
  set.mm_per_unit = 10;
  set.axes = *Axes::parse("FLU");
  MarkerFrame sent = marker_frame(1, 1);
  sent.position_mm[0] = {1, 2, 3};
  MarkerStreamDecoder as_stated;
  push_all(as_stated, datagrams_of(set));
  EXPECT_EQ(push_all(as_stated, datagrams_of(sent)).at(0).frame.position_mm[0], (Position{20, 30, 10}));
  MarkerStreamDecoder overridden({.mm_per_unit = 1000, .axes = Axes::parse("RUB")});
  const auto events = push_all(overridden, datagrams_of(set));
  EXPECT_EQ(events.at(1).set->mm_per_unit, 1000);
  EXPECT_EQ(events.at(1).set->axes.letters(), "RUB");
  EXPECT_EQ(push_all(overridden, datagrams_of(sent)).at(0).frame.position_mm[0], (Position{-1000, 2000, -3000}));
}

TEST(MarkerStreamDecoder, CountsMarkersThatAreNotFinite) {
  MarkerStreamDecoder decoder;
  push_all(decoder, datagrams_of(marker_set(2)));
  MarkerFrame sent = marker_frame(1, 2);
  sent.position_mm[1].y = std::nanf("");
  EXPECT_EQ(push_all(decoder, datagrams_of(sent)).at(0).frame.state[1], MarkerState::kMissing);
  EXPECT_EQ(decoder.counters().not_finite_markers.value(), 1u);
}

TEST(MarkerStreamDecoder, ConsumesNothingWhenFull) {
  MarkerStreamDecoder decoder({.event_capacity = 4});
  push_all(decoder, datagrams_of(marker_set(1)));
  std::uint64_t sequence = 0;
  while (decoder.ready()) decoder.push(datagrams_of(marker_frame(++sequence, 1)).at(0), 0);
  const auto received = decoder.counters().datagrams.received.value();
  EXPECT_FALSE(decoder.push(datagrams_of(marker_frame(++sequence, 1)).at(0), 0));
  EXPECT_EQ(decoder.counters().datagrams.received.value(), received);
  const auto held = decoder.counters().frames.held.value();
  EXPECT_EQ(pop_all(decoder).size(), held);
  EXPECT_EQ(held, sequence - 1);
  EXPECT_TRUE(decoder.ready());
  expect_settled(decoder);
}

TEST(MarkerStreamDecoder, SurvivesChaosWithBalancedLedgers) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::vector<Bytes> datagrams;
    std::uint64_t sent_frames = 0;
    for (std::uint64_t sequence = 0; sequence < 600; ++sequence) {
      const bool large = sequence / 100 % 2 == 1;
      const std::uint32_t id = large ? 2 : 1;
      const std::size_t count = large ? 256 : 50;
      if (sequence % 20 == 0) {
        for (auto& datagram : datagrams_of(marker_set(count, id))) datagrams.push_back(datagram);
      }
      for (auto& datagram : datagrams_of(marker_frame(sequence, count, id))) datagrams.push_back(datagram);
      ++sent_frames;
    }
    std::vector<Bytes> received;
    for (auto& datagram : datagrams) {
      if (random() % 20 == 0) continue;
      received.push_back(datagram);
      if (random() % 20 == 0) received.push_back(datagram);
      if (random() % 50 == 0) received.back()[random() % received.back().size()] ^= std::byte{16};
    }
    for (std::size_t i = 0; i + 6 < received.size(); ++i) std::swap(received[i], received[i + random() % 6]);
    MarkerStreamDecoder decoder;
    std::map<std::uint64_t, int> times;
    for (const auto& event : push_all(decoder, received)) {
      if (event.kind != Kind::kFrame) continue;
      ++times[event.frame.header.sequence];
      const auto& header = event.frame.header;
      ASSERT_TRUE(same_markers(event.frame, marker_frame(header.sequence, event.frame.count, header.set_id)));
    }
    for (const auto& [sequence, count] : times) EXPECT_EQ(count, 1) << sequence;
    EXPECT_GT(times.size(), sent_frames / 2);
    expect_settled(decoder);
    const auto& counters = decoder.counters();
    std::uint64_t errors = 0;
    for (const auto& error : counters.refused) errors += error.value();
    EXPECT_EQ(errors, counters.datagrams.refused.value());
    EXPECT_EQ(counters.datagrams.received.value(), received.size());
    EXPECT_GT(counters.of(DecodeError::kBadChecksum), 0u);
    EXPECT_GT(counters.incomplete_frames.value(), 0u);
    EXPECT_EQ(counters.frames.emitted.value(), times.size());
  }
}

TEST(MarkerStreamDecoder, SurvivesRandomBytes) {
  std::mt19937 random(3);
  MarkerStreamDecoder decoder;
  for (int i = 0; i < 2000; ++i) {
    Bytes datagram(random() % 1600);
    for (auto& byte : datagram) byte = static_cast<std::byte>(random());
    push_all(decoder, {datagram});
  }
  EXPECT_EQ(decoder.counters().datagrams.refused.value(), 2000u);
}

TEST(MarkerStreamDecoder, AllocatesNothingForFramesAndRepeatedSets) {
  MarkerStreamDecoder decoder;
  const auto set = datagrams_of(marker_set(256));
  for (const auto& datagram : set) decoder.push(datagram, 0);
  std::vector<Bytes> datagrams = set;
  for (std::uint64_t sequence = 0; sequence < 30; ++sequence) {
    for (auto& datagram : datagrams_of(marker_frame(sequence, 256))) datagrams.push_back(datagram);
  }
  datagrams.push_back(Bytes(30));
  SourceEvent event;
  std::uint64_t frames = 0;
  const auto before = test::allocations_of_this_thread();
  for (const auto& datagram : datagrams) {
    decoder.push(datagram, 0);
    while (decoder.pop(event)) frames += event.kind == Kind::kFrame ? 1 : 0;
  }
  decoder.flush();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_EQ(frames, 30u);
}

TEST(MarkerStreamDecoder, NamesOptionsOutOfRange) {
  EXPECT_THROW(MarkerStreamDecoder({.mm_per_unit = 0}), UserError);
  EXPECT_THROW(MarkerStreamDecoder({.reassembly_frames = 65}), UserError);
  EXPECT_THROW(MarkerStreamDecoder({.event_capacity = 2}), UserError);
}

}  // namespace
}  // namespace risorius
