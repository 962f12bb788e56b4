#include "capture/wire/qtm_session.h"

#include <gtest/gtest.h>
#include <random>

#include "capture/errors.h"
#include "support/allocation_counter.h"
#include "support/hex.h"
#include "support/session_events.h"

namespace risorius {
namespace {

using test::balanced;
using test::events_of;
using test::hex;
using test::kinds_of;
using Bytes = std::vector<std::byte>;

constexpr std::int64_t kSecond = 1'000'000'000;
const std::string kLabels =
    "<QTM_Parameters_Ver_1.13><The_3D><AxisUpwards>+Z</AxisUpwards><Labels>2</Labels><Label><Name>chin</Name></Label>"
    "<Label><Name>nose</Name></Label></The_3D></QTM_Parameters_Ver_1.13>";
const std::string kGeneral = "<Q><General><Frequency>120</Frequency></General></Q>";

Bytes text(QtmPacketType type, std::string_view words) {
  ByteAppender out;
  append_qtm_text(type, words, out);
  return {out.bytes().begin(), out.bytes().end()};
}
Bytes command(std::string_view words) { return text(QtmPacketType::kCommand, words); }
Bytes event(QtmEvent which) {
  ByteAppender out;
  append_qtm_event(which, out);
  return {out.bytes().begin(), out.bytes().end()};
}
Bytes frame(std::uint32_t number, const QtmComponents& components = {.markers = true}, std::size_t markers = 2) {
  ByteAppender out;
  std::vector<std::optional<std::array<float, 3>>> positions(markers, std::array<float, 3>{1, 2, 3});
  append_qtm_data(std::uint64_t{number} * 10000, number, components, positions, Timecode{1, 2, 3, 4, 30}, out);
  return {out.bytes().begin(), out.bytes().end()};
}

/// A session and the time; says one thing at a time, as a server would.
struct Talk {
  explicit Talk(std::uint16_t udp_port = 0, const std::string& label_prefix = "")
      : session({.tracker = {}, .label_prefix = label_prefix}) {
    session.use_udp_port(udp_port);
    session.connected(now_ns);
  }
  /// The commands that the session answers with, one line each.
  std::string hear(const Bytes& bytes) {
    EXPECT_EQ(session.receive(bytes, now_ns), bytes.size());
    return answers();
  }
  std::string answers() {
    std::string lines;
    const Bytes said = test::said_by(session);
    std::span<const std::byte> rest = said;
    QtmPacket packet;
    while (take_qtm_packet(rest, 1 << 20, packet) == PacketStatus::kWhole) {
      EXPECT_EQ(packet.type, QtmPacketType::kCommand);
      EXPECT_EQ(packet.body.back(), std::byte{0});
      lines += std::string(qtm_text(packet.body)) + "\n";
    }
    EXPECT_TRUE(rest.empty());
    return lines;
  }
  std::string wait(std::int64_t ns) {
    now_ns += ns;
    session.tick(now_ns);
    return answers();
  }
  void stream() {
    hear(command("QTM RT Interface connected"));
    hear(command("Version set to 1.27"));
    hear(event(QtmEvent::kConnected));
    hear(text(QtmPacketType::kXml, kGeneral));
    hear(text(QtmPacketType::kXml, kLabels));
  }
  QtmSession session;
  std::int64_t now_ns = 1000 * kSecond;
};

TEST(QtmSession, AsksOneThingAfterTheOther) {
  Talk talk;
  EXPECT_EQ(talk.answers(), "") << "the server greets first";
  EXPECT_EQ(talk.hear(command("QTM RT Interface connected")), "Version 1.27\n");
  EXPECT_EQ(talk.hear(command("Version set to 1.27")), "GetState\n");
  EXPECT_EQ(talk.hear(event(QtmEvent::kConnected)), "GetParameters General\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kGeneral)), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kLabels)), "StreamFrames AllFrames 3D 3DNoLabels Timecode\n");
  talk.hear(frame(7));
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"chin", "nose"}));
  EXPECT_EQ(events[1].set->rate_hz, 120);
  EXPECT_EQ(events[1].set->axes.letters(), "FLU");
  EXPECT_EQ(events[2].frame.header.set_id, events[1].set->id);
  EXPECT_EQ(events[2].frame.header.sequence, 7u);
  EXPECT_EQ(events[2].frame.header.capture_time_ns, 70'000'000);
  EXPECT_EQ(events[2].frame.header.receive_time_ns, talk.now_ns);
  EXPECT_EQ(events[2].frame.position_mm[0], (Position{2, 3, 1}));  // front 1, left 2, up 3
  EXPECT_EQ(talk.session.counters().link, LinkState::kStreaming);
  EXPECT_TRUE(balanced(talk.session));
}

/// Settings with the labels, in this order.
Bytes labels(const std::vector<std::string>& names) {
  std::string xml = "<Q><The_3D><AxisUpwards>+Z</AxisUpwards>";
  for (const auto& name : names) xml += "<Label><Name>" + name + "</Name></Label>";
  return text(QtmPacketType::kXml, xml + "</The_3D></Q>");
}

TEST(QtmSession, TakesOnlyTheLabelsWithItsPrefixAndTakesItOff) {
  Talk talk(0, "Ben_");
  talk.stream();
  talk.hear(labels({"Anna_chin", "Ben_nose", "Anna_nose", "Ben_chin"}));
  ByteAppender out;
  const std::vector<std::optional<std::array<float, 3>>> positions{{{1, 0, 0}}, {{2, 0, 0}}, std::nullopt, {{4, 0, 0}}};
  append_qtm_data(10000, 1, {.markers = true}, positions, Timecode{}, out);
  talk.hear({out.bytes().begin(), out.bytes().end()});
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"nose", "chin"}));
  ASSERT_EQ(events[2].frame.count, 2u);
  EXPECT_EQ(events[2].frame.position_mm[0], (Position{0, 0, 2}));  // front is +x of QTM
  EXPECT_EQ(events[2].frame.position_mm[1], (Position{0, 0, 4}));
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, APrefixThatNoLabelHasIsARefusalOfItsOwn) {
  Talk talk(0, "Carl_");
  talk.stream();
  EXPECT_GE(talk.session.counters().of(QtmRefusal::kNoMarkers), 1u);
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kBadSettings), 0u);
  talk.hear(frame(7));
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kNoLabels), 1u);
}

TEST(QtmSession, GoesDownUntilAVersionIsAccepted) {
  Talk talk;
  std::string asked = talk.hear(command("QTM RT Interface connected"));
  for (int minor = 26; minor >= 13; --minor) {
    // Some servers refuse with an error, some with a reply.
    const auto type = minor % 2 == 0 ? QtmPacketType::kError : QtmPacketType::kCommand;
    asked = talk.hear(text(type, "Version NOT supported"));
    EXPECT_EQ(asked, "Version 1." + std::to_string(minor) + "\n");
  }
  EXPECT_EQ(talk.hear(command("Version set to 1.13")), "GetState\n");
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kErrorReply), 0u) << "finding the version is no fault";
  EXPECT_EQ(talk.session.dialog().version(), "1.13");
}

TEST(QtmSession, WorksWithoutAnAcceptedVersion) {
  Talk talk;
  talk.hear(command("QTM RT Interface connected"));
  std::string asked;
  for (int i = 0; i < 20; ++i) asked = talk.hear(text(QtmPacketType::kError, "Parse error"));
  EXPECT_EQ(asked, "GetState\n");
  EXPECT_EQ(talk.session.dialog().version(), "1.1");
}

TEST(QtmSession, TakesTheVersionThatTheServerSaysItSet) {
  Talk talk;
  talk.hear(command("QTM RT Interface connected"));
  EXPECT_EQ(talk.hear(command("Version set to 1.9")), "GetState\n");
  EXPECT_EQ(talk.session.dialog().version(), "1.9");
}

TEST(QtmSession, GoesOnWhereStateAndGeneralSettingsAreNotAnswered) {
  Talk talk;
  talk.hear(command("QTM RT Interface connected"));
  talk.hear(command("Version set to 1.27"));
  EXPECT_EQ(talk.wait(kSecond / 2), "");
  EXPECT_EQ(talk.wait(kSecond), "GetParameters General\n");
  EXPECT_EQ(talk.wait(2 * kSecond), "GetParameters 3D\n");
  EXPECT_FALSE(talk.session.failed());
  talk.wait(6 * kSecond);
  EXPECT_TRUE(talk.session.failed()) << "without labels there is nothing to do";
}

TEST(QtmSession, AsksForFewerComponentsWhereTheServerKnowsFewer) {
  Talk talk;
  talk.stream();
  EXPECT_EQ(talk.hear(text(QtmPacketType::kError, "Parse error")), "StreamFrames AllFrames 3D Timecode\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kError, "Parse error")), "StreamFrames AllFrames 3D\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kError, "Parse error")), "");
  EXPECT_EQ(talk.wait(2 * kSecond), "GetParameters 3D\n") << "after a rest it begins again";
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kErrorReply), 3u);
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, AsksForFramesByUdpWhereItsPortIs) {
  Talk talk(4711);
  talk.stream();
  EXPECT_EQ(kinds_of(talk.session), "");
  talk.hear(text(QtmPacketType::kError, "Parse error"));
  talk.session.receive_datagram(frame(1), talk.now_ns);
  EXPECT_EQ(kinds_of(talk.session), "NSF");
}

TEST(QtmSession, NamesTheUdpPort) {
  Talk talk(4711);
  talk.hear(command("QTM RT Interface connected"));
  talk.hear(command("Version set to 1.27"));
  talk.hear(event(QtmEvent::kConnected));
  talk.hear(text(QtmPacketType::kXml, kGeneral));
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kLabels)), "StreamFrames AllFrames UDP:4711 3D 3DNoLabels Timecode\n");
}

TEST(QtmSession, FindsEventsBetweenReplies) {
  Talk talk;
  talk.hear(command("QTM RT Interface connected"));
  EXPECT_EQ(talk.hear(event(QtmEvent::kCaptureStarted)), "");
  EXPECT_EQ(talk.hear(command("Version set to 1.27")), "GetState\n");
  talk.hear(event(QtmEvent::kCaptureStarted));
  EXPECT_EQ(talk.hear(event(QtmEvent::kTrigger)), "");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kGeneral)), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(event(QtmEvent::kWaitingForTrigger)), "");
  talk.hear(text(QtmPacketType::kXml, kLabels));
  talk.hear(frame(1));
  talk.hear(event(QtmEvent::kCaptureStopped));
  talk.hear(event(QtmEvent::kCaptureStopped));
  EXPECT_EQ(kinds_of(talk.session), "(NSF)");
}

TEST(QtmSession, ReadsLabelsAgainWhenSettingsChange) {
  Talk talk;
  talk.stream();
  talk.hear(frame(1));
  talk.now_ns += 2 * kSecond;
  EXPECT_EQ(talk.hear(event(QtmEvent::kCameraSettingsChanged)), "GetParameters 3D\n");
  talk.hear(frame(2));  // still by the old labels
  std::string other = kLabels;
  other.replace(other.find("chin"), 4, "lips");
  talk.hear(text(QtmPacketType::kXml, other));
  talk.hear(frame(3));
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSFFSF");
  EXPECT_EQ(events[4].set->names[0], "lips");
  EXPECT_NE(events[5].frame.header.set_id, events[3].frame.header.set_id);
  // Back to the first labels: the set of before, not another.
  talk.hear(text(QtmPacketType::kXml, kLabels));
  talk.hear(frame(4));
  const auto later = events_of(talk.session);
  ASSERT_EQ(kinds_of(later), "SF");
  EXPECT_EQ(later[0].set, events[1].set);
}

TEST(QtmSession, AsksForLabelsWhenTheNumberOfMarkersIsAnother) {
  Talk talk;
  talk.stream();
  talk.now_ns += 2 * kSecond;
  EXPECT_EQ(talk.hear(frame(1, {.markers = true}, 3)), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(frame(2, {.markers = true}, 1)), "") << "one question at a time";
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kCountMismatch), 2u);
  EXPECT_EQ(kinds_of(talk.session), "");
}

TEST(QtmSession, PutsFramesTogetherThatComeInSeveralPackets) {
  Talk talk(4711);
  talk.stream();
  const auto datagram = [&](const Bytes& bytes) { talk.session.receive_datagram(bytes, talk.now_ns); };
  // The first frame teaches that the timecode comes on its own; it goes without.
  datagram(frame(1));
  datagram(frame(1, {.timecode = true}));
  datagram(frame(2));
  EXPECT_EQ(kinds_of(talk.session), "NSF");
  EXPECT_EQ(talk.session.counters().frames.held.value(), 1u);
  datagram(frame(2, {.timecode = true}));
  auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "F");
  EXPECT_EQ(events[0].frame.header.timecode.minutes, 2);
  // The parts in the other order.
  datagram(frame(3, {.timecode = true}));
  datagram(frame(3));
  events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "F");
  EXPECT_EQ(events[0].frame.header.timecode.minutes, 2);
  EXPECT_TRUE(balanced(talk.session));
  EXPECT_EQ(talk.session.counters().datagrams.dropped.value(), 1u);
}

TEST(QtmSession, DoesNotWaitForAPartThatNoLongerComes) {
  Talk talk(4711);
  talk.stream();
  const auto datagram = [&](const Bytes& bytes) { talk.session.receive_datagram(bytes, talk.now_ns); };
  datagram(frame(1));
  datagram(frame(1, {.timecode = true}));
  datagram(frame(2));
  EXPECT_EQ(kinds_of(talk.session), "NSF");
  datagram(frame(3));  // begins: frame 2 goes without its part, and frame 3 does not wait
  EXPECT_EQ(kinds_of(talk.session), "FF");
  datagram(frame(3, {.timecode = true}));
  datagram(frame(4));
  EXPECT_EQ(kinds_of(talk.session), "");
  talk.wait(30'000'000);
  EXPECT_EQ(kinds_of(talk.session), "F");
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, GivesUpAFrameOfWhichTheMarkersAreLost) {
  Talk talk(4711);
  talk.stream();
  talk.session.receive_datagram(frame(1, {.timecode = true}), talk.now_ns);
  talk.session.receive_datagram(frame(2), talk.now_ns);
  EXPECT_EQ(kinds_of(talk.session), "NSF");
  EXPECT_EQ(talk.session.counters().incomplete_frames.value(), 1u);
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, TakesAFrameNumberThatGoesBackForANewStream) {
  Talk talk;
  talk.stream();
  for (const std::uint32_t number : {100U, 101U, 101U, 105U, 3U, 4U}) talk.hear(frame(number));
  EXPECT_EQ(kinds_of(talk.session), "NSFFFNSFF");
  EXPECT_EQ(talk.session.counters().datagrams.dropped.value(), 1u) << "the repeated frame";
  // Over UDP a frame may come late without that meaning anything.
  Talk by_udp(4711);
  by_udp.stream();
  for (const std::uint32_t number : {100U, 102U, 101U, 103U, 3U})
    by_udp.session.receive_datagram(frame(number), by_udp.now_ns);
  EXPECT_EQ(kinds_of(by_udp.session), "NSFFFFNSF");
}

TEST(QtmSession, EndsTheStreamWithTheData) {
  Talk talk;
  talk.stream();
  talk.hear(frame(1));
  EXPECT_EQ(talk.hear(hex("08000000 04000000")), "");
  EXPECT_EQ(kinds_of(talk.session), "NSFE");
  EXPECT_EQ(talk.hear(event(QtmEvent::kRtFromFileStarted)), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kLabels)), "StreamFrames AllFrames 3D 3DNoLabels Timecode\n");
  talk.hear(frame(1));
  EXPECT_EQ(kinds_of(talk.session), "NSF");
}

TEST(QtmSession, WaitsForLabels) {
  Talk talk;
  talk.hear(command("QTM RT Interface connected"));
  talk.hear(command("Version set to 1.27"));
  talk.hear(event(QtmEvent::kConnectionClosed));
  talk.hear(text(QtmPacketType::kXml, kGeneral));
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, "<Q><The_3D><Labels>0</Labels></The_3D></Q>")), "");
  EXPECT_EQ(talk.wait(2 * kSecond), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kError, "No 3D settings")), "");
  EXPECT_EQ(talk.wait(2 * kSecond), "GetParameters 3D\n");
  EXPECT_EQ(talk.hear(text(QtmPacketType::kXml, kLabels)), "StreamFrames AllFrames 3D 3DNoLabels Timecode\n");
}

TEST(QtmSession, EndsWhatWasGoingOnWhenTheConnectionIsLost) {
  Talk talk;
  talk.stream();
  talk.hear(event(QtmEvent::kCaptureStarted));
  talk.hear(frame(1));
  talk.session.disconnected();
  EXPECT_EQ(kinds_of(talk.session), "(NSFE)");
  EXPECT_EQ(talk.session.counters().link, LinkState::kLost);
  talk.session.connected(talk.now_ns);
  talk.stream();
  talk.hear(frame(1));
  EXPECT_EQ(kinds_of(talk.session), "NSF");
}

TEST(QtmSession, GivesUpAServerThatIsNoneOrSilent) {
  Talk silent;
  silent.wait(6 * kSecond);
  EXPECT_TRUE(silent.session.failed());
  Talk other;
  other.hear(command("220 mail.example.org"));
  EXPECT_TRUE(other.session.failed());
  Talk garbage;
  garbage.session.receive(hex("48545450 2F312E31"), garbage.now_ns);
  EXPECT_TRUE(garbage.session.failed());
  EXPECT_EQ(garbage.session.counters().of(QtmRefusal::kBadSize), 1u);
  EXPECT_TRUE(balanced(garbage.session));
}

TEST(QtmSession, ProbesAConnectionThatHasGoneQuiet) {
  Talk talk;
  talk.stream();
  talk.hear(frame(1));
  EXPECT_EQ(talk.wait(6 * kSecond), "GetState\n");
  talk.hear(event(QtmEvent::kConnected));
  EXPECT_EQ(talk.wait(6 * kSecond), "GetState\n");
  talk.wait(6 * kSecond);
  EXPECT_TRUE(talk.session.failed());
}

TEST(QtmSession, CountsWhatIsOfNoUse) {
  Talk talk;
  talk.stream();
  // An unlabelled marker beside the two labelled ones; 5 and 7 per mille.
  talk.hear(
      hex("60000000 03000000 0000000000000000 01000000 02000000"
          "28000000 01000000 02000000 0500 0700 0000803F0000004000004040 FFFFFFFFFFFFFFFFFFFFFFFF"
          "20000000 02000000 01000000 0000 0000 0000803F0000004000004040 63000000"));
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[2].frame.state[0], MarkerState::kMeasured);
  EXPECT_EQ(events[2].frame.state[1], MarkerState::kMissing);
  EXPECT_EQ(talk.session.qtm_counters().unlabelled_markers.value(), 1u);
  EXPECT_EQ(talk.session.qtm_counters().drop_rate_per_mille.value(), 5u);
  EXPECT_EQ(talk.session.qtm_counters().out_of_sync_rate_per_mille.value(), 7u);
  // A time stamp beyond any clock.
  talk.hear(hex("18000000 03000000 FFFFFFFFFFFFFFFF 02000000 00000000"));
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kBadTime), 1u);
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, ConvertsUnitAndAxesByConfiguration) {
  QtmSession session(
      {.tracker = {.stream_id = 3, .mm_per_unit = 1000, .axes = Axes::parse("LUF")}, .label_prefix = ""});
  session.connected(0);
  for (const Bytes& bytes :
       {command("QTM RT Interface connected"), command("Version set to 1.27"), event(QtmEvent::kConnected),
        text(QtmPacketType::kXml, kGeneral), text(QtmPacketType::kXml, kLabels), frame(1)}) {
    EXPECT_EQ(session.receive(bytes, 0), bytes.size());
  }
  const auto events = events_of(session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_EQ(events[2].frame.position_mm[0], (Position{1000, 2000, 3000}));
  EXPECT_EQ(events[2].frame.header.stream_id, 3u);
  EXPECT_THROW(QtmSession({.tracker = {.mm_per_unit = 0}, .label_prefix = ""}), UserError);
  EXPECT_THROW(QtmSession({.tracker = {.event_capacity = 3}, .label_prefix = ""}), UserError);
}

TEST(QtmSession, KnowsTheTimeBetterThanItsMicroseconds) {
  Talk talk;
  talk.stream();  // 120 Hz
  const auto frame_at = [&](std::uint32_t number, std::uint64_t us) {
    ByteAppender out;
    const std::vector<std::optional<std::array<float, 3>>> positions(2);
    append_qtm_data(us, number, {.markers = true}, positions, {}, out);
    talk.hear({out.bytes().begin(), out.bytes().end()});
    return events_of(talk.session).back().frame.header.capture_time_ns;
  };
  EXPECT_EQ(frame_at(1, 8333), 8333333);    // 1 / 120 s, rounded
  EXPECT_EQ(frame_at(2, 16666), 16666667);  // 2 / 120 s, cut off
  EXPECT_EQ(frame_at(3, 25007), 25007000);  // on no multiple: as it is
  EXPECT_EQ(frame_at(4, 9000000000), 9000000000000);
}

TEST(QtmSession, WhateverTheLabelsAreTheSetIsOne) {
  Talk talk;
  talk.stream();
  talk.hear(labels({"nose", "nose", "", "a\tb", std::string(80, 'L')}));
  talk.hear(frame(1, {.markers = true}, 5));
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_TRUE(problems_of(*events[1].set).empty()) << problems_of(*events[1].set).front();
  EXPECT_EQ(events[1].set->names, (std::vector<std::string>{"nose", "nose#2", "3", "a?b", std::string(63, 'L')}));
  EXPECT_TRUE(balanced(talk.session));
}

TEST(QtmSession, MoreLabelsThanAFrameHoldsAreARefusalOfTheirOwn) {
  Talk talk;
  talk.stream();
  std::vector<std::string> names;
  for (std::size_t i = 0; i <= kMaxMarkers; ++i) names.push_back("m" + std::to_string(i));
  talk.hear(labels(names));
  talk.hear(frame(1));
  EXPECT_EQ(kinds_of(talk.session), "");
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kTooManyMarkers), 2u) << "of the labels, and of the frame";
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kNoLabels), 0u);
  // Of the same name 30,000 times (which took minutes to tell apart) no more is read than it takes to refuse them.
  talk.hear(labels(std::vector<std::string>(30'000, "a")));
  EXPECT_EQ(talk.session.counters().of(QtmRefusal::kTooManyMarkers), 3u);
}

TEST(QtmSession, ARateThatIsNoneIsNotStated) {
  Talk talk;
  talk.stream();
  talk.hear(text(QtmPacketType::kXml, "<Q><General><Frequency>1e30</Frequency></General></Q>"));
  talk.hear(frame(1));
  const auto events = events_of(talk.session);
  ASSERT_EQ(kinds_of(events), "NSF");
  EXPECT_TRUE(problems_of(*events[1].set).empty());
}

Bytes whole_conversation() {
  using test::operator+;
  Bytes all = command("QTM RT Interface connected") + command("Version set to 1.27") + event(QtmEvent::kConnected) +
              text(QtmPacketType::kXml, kGeneral) + text(QtmPacketType::kXml, kLabels);
  const QtmComponents components{.markers = true, .unlabelled = true, .timecode = true};
  for (std::uint32_t number = 1; number < 6; ++number) all = all + frame(number, components);
  return all + event(QtmEvent::kCaptureStarted) + hex("08000000 04000000");
}

TEST(QtmSession, GivesTheSameEventsHoweverTheStreamIsCut) {
  const Bytes all = whole_conversation();
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    QtmSession session({.tracker = {}, .label_prefix = ""});
    session.connected(0);
    std::size_t used = session.receive(std::span(all).first(cut), 0);
    ASSERT_LE(used, cut);
    used += session.receive(std::span(all).subspan(used), 0);
    ASSERT_EQ(used, all.size());
    ASSERT_EQ(kinds_of(session), "NSFFFFF(E") << cut;
    ASSERT_TRUE(balanced(session));
  }
}

TEST(QtmSession, SurvivesMutatedConversations) {
  const Bytes good = whole_conversation();
  std::mt19937_64 random(23);
  std::size_t frames = 0, failures = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    for (std::uint64_t changes = 1 + random() % 5; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 3 == 0 ? 0xFF : random());
    QtmSession session({.tracker = {.event_capacity = 32}, .label_prefix = ""});
    session.use_udp_port(i % 2 == 0 ? 0 : 5);
    session.connected(0);
    std::span<const std::byte> rest = bytes;
    const std::size_t first = session.receive(rest.first(rest.size() / 2), 0);
    session.receive(rest.subspan(first), 0);
    if (i % 2 == 1) session.receive_datagram(rest.subspan(random() % rest.size()), 0);
    session.tick(1 + static_cast<std::int64_t>(random() % 1000) * kSecond);
    session.disconnected();
    failures += session.failed() ? 1 : 0;
    for (const auto& one : events_of(session)) frames += one.kind == SourceEventKind::kFrame ? 1 : 0;
    session.flush();
    ASSERT_TRUE(balanced(session));
    ASSERT_EQ(session.counters().frames.held.value(), 0u);
  }
  EXPECT_GT(frames, 1000u);
  EXPECT_GT(failures, 100u);
}

TEST(QtmSession, AllocatesNothingPerFrame) {
  Talk talk;
  talk.stream();
  const QtmComponents components{.markers = true, .unlabelled = true, .timecode = true};
  std::vector<Bytes> frames;
  for (std::uint32_t number = 1; number < 50; ++number) frames.push_back(frame(number, components));
  talk.hear(frames[0]);
  SourceEvent popped;
  const auto before = test::allocations_of_this_thread();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    talk.session.receive(frames[i], 0);
    while (talk.session.pop(popped)) {
    }
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_EQ(popped.frame.header.sequence, 49u);
}

}  // namespace
}  // namespace risorius
