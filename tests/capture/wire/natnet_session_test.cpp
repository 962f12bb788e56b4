#include "capture/wire/natnet_session.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "capture/errors.h"
#include "capture/wire/natnet_client_fixture.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

using test::HandPacket;
using test::kMs;
using test::natnet_face_frame;
using test::natnet_labelled;
using test::natnet_server_info;
using test::natnet_two_faces;
using test::natnet_two_faces_model;
using test::NatnetHandFrame;
using test::NatnetHandModel;
using Client = test::NatnetClientFixture;
using Bytes = std::vector<std::byte>;
using Kind = SourceEventKind;

TEST(NatnetSession, TriesTheFormsOfConnectInTurnAndBacksOff) {
  Client client;
  client.tick();
  std::vector<std::pair<std::int64_t, std::size_t>> tries;  // ms, bytes
  const std::int64_t begin_ns = client.now_ns;
  for (int ms = 0; ms < 60'000; ++ms) {
    for (const Bytes& datagram : client.sent()) tries.emplace_back((client.now_ns - begin_ns) / kMs, datagram.size());
    client.advance(1);
  }
  ASSERT_GT(tries.size(), 12u);
  for (std::size_t i = 0; i < tries.size(); ++i) EXPECT_EQ(tries[i].second, (std::array{268u, 9u, 4u}[i % 3]));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(tries[i].first, static_cast<std::int64_t>(250 * i));
  EXPECT_EQ(tries[4].first - tries[3].first, 500);
  EXPECT_EQ(tries.back().first - tries[tries.size() - 2].first, 5000);
  EXPECT_EQ(client.session.counters().link, LinkState::kConnecting);
}

TEST(NatnetSession, AsksForModelsInBothForms) {
  Client client;
  client.tick();
  client.push(natnet_server_info(4, 1));
  client.push(test::natnet_message(256, {}).bytes());  // "unrecognized", of servers that know no rate
  std::vector<std::size_t> sizes;
  for (int ms = 0; ms < 3000; ++ms) {
    for (const Bytes& datagram : client.sent()) {
      NatnetPacket packet;
      ASSERT_EQ(decode_natnet(datagram, packet), NatnetError::kNone);
      if (packet.message() == NatnetMessage::kRequestModelDef) sizes.push_back(datagram.size());
    }
    client.advance(1);
  }
  ASSERT_GE(sizes.size(), 3u);
  EXPECT_EQ(sizes[0], 4u);
  EXPECT_EQ(sizes[1], 8u) << "there are servers that answer only a request with a mask";
  EXPECT_EQ(sizes[2], 4u);
}

TEST(NatnetSession, AsksForRateAndModelThenGivesNamesAndFrames) {
  Client client;
  client.tick();
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect));
  client.push(natnet_server_info(4, 1));
  EXPECT_TRUE(client.has_sent(NatnetMessage::kRequest));
  client.push(natnet_face_frame(true, 6).datagram());
  EXPECT_EQ(client.session.counters().of(NatnetError::kUnknownModel), 1u);
  client.push(test::natnet_message(3, HandPacket().f32({240})).bytes());
  EXPECT_TRUE(client.has_sent(NatnetMessage::kRequestModelDef));
  client.push(NatnetHandModel{}.marker_set("face", {"brow", "nose", "chin"}).datagram());
  EXPECT_EQ(client.session.counters().link, LinkState::kWaiting);
  client.push(natnet_face_frame(true, 7).datagram());
  EXPECT_EQ(client.session.counters().link, LinkState::kStreaming);

  ASSERT_EQ(client.kinds(), (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame}));
  const MarkerSet& set = *client.events[1].set;
  EXPECT_EQ(set.names, (std::vector<std::string>{"brow", "nose", "chin"}));
  EXPECT_EQ(set.rate_hz, 240);
  EXPECT_EQ(set.mm_per_unit, 1000);
  const MarkerFrame& frame = client.last_frame();
  EXPECT_EQ(frame.header.sequence, 7u);
  EXPECT_EQ(frame.header.set_id, set.id);
  EXPECT_EQ(frame.header.capture_time_ns, 2'000'000'000);  // 20e6 ticks of 10 MHz
  EXPECT_EQ(frame.header.receive_time_ns, client.now_ns);
  ASSERT_EQ(frame.count, 3u);
  EXPECT_EQ(frame.state[0], MarkerState::kMeasured);
  EXPECT_EQ(frame.position_mm[0], (Position{100, 200, 300}));  // metres on the wire
  EXPECT_EQ(frame.state[1], MarkerState::kMissing);            // occluded, with a position
  EXPECT_EQ(frame.position_mm[2], (Position{700, 800, 900}));
}

TEST(NatnetSession, AServerThatDoesNotKnowItsRateIsAskedForItsModelAllTheSame) {
  for (const bool says_so : {true, false}) {
    Client client;
    client.tick();
    client.push(natnet_server_info(3, 0));
    if (says_so) {
      client.push(test::natnet_message(100, {}).bytes());
    } else {
      client.advance(260);
    }
    EXPECT_TRUE(client.has_sent(NatnetMessage::kRequestModelDef));
    client.advance(600);
    EXPECT_TRUE(client.has_sent(NatnetMessage::kRequestModelDef));  // and again, as long as there is no answer
    client.push(NatnetHandModel{.sized = false}.marker_set("face", {"brow"}).datagram());
    ASSERT_EQ(client.kinds(), (std::vector{Kind::kNewSession, Kind::kMarkerSet}));
    EXPECT_EQ(client.events[1].set->rate_hz, 0);
  }
}

TEST(NatnetSession, AVersionThatChangesWhileFramesComeCostsNoFrame) {
  Client client;
  client.connect(3, 0);
  client.push(natnet_face_frame(false, 1).datagram());
  client.sent();
  client.push(natnet_face_frame(true, 2).datagram());  // 4.1 from here on, unannounced
  EXPECT_EQ(client.last_frame().header.sequence, 2u);
  EXPECT_EQ(client.last_frame().position_mm[2], (Position{700, 800, 900}));
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect));
  client.push(natnet_server_info(4, 1));
  EXPECT_EQ(client.session.server()->version, (NatnetVersion{4, 1}));
  EXPECT_TRUE(client.has_sent(NatnetMessage::kRequestModelDef));
  client.push(NatnetHandModel{}.marker_set("face", {"brow", "nose", "chin"}).datagram());
  client.push(natnet_face_frame(true, 3).datagram());
  EXPECT_EQ(client.last_frame().header.sequence, 3u);
  EXPECT_EQ(client.session.counters().sessions.value(), 1u);
  EXPECT_EQ(client.session.counters().sets_changed.value(), 1u);
  EXPECT_EQ(client.session.counters().datagrams.refused.value(), 0u);
}

TEST(NatnetSession, AnnouncedVersionsAreAskedForOnce) {
  Client client;
  client.connect();
  client.sent();
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.params = NatnetSuffix::kBitstreamChanged;
  client.push(hand.datagram());
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect));
  client.push(hand.datagram());
  EXPECT_FALSE(client.has_sent(NatnetMessage::kConnect));
}

TEST(NatnetSession, NoFrameIsTakenBetweenAChangeOfModelsAndTheirDefinition) {
  Client client;
  client.connect();
  NatnetHandFrame changed = natnet_face_frame(true, 8);
  changed.params = NatnetSuffix::kModelsChanged;
  client.sent();
  client.push(changed.datagram());
  EXPECT_TRUE(client.has_sent(NatnetMessage::kRequestModelDef));
  client.push(natnet_face_frame(true, 9).datagram());
  EXPECT_EQ(client.session.counters().of(NatnetError::kModelChanging), 2u);
  client.push(NatnetHandModel{}.marker_set("face", {"chin", "nose", "brow"}).datagram());
  client.push(natnet_face_frame(true, 10).datagram());
  EXPECT_EQ(client.events[client.events.size() - 2].kind, Kind::kMarkerSet);
  EXPECT_EQ(client.events[client.events.size() - 2].set->names.front(), "chin");
  EXPECT_EQ(client.last_frame().header.set_id, client.events[client.events.size() - 2].set->id);
  EXPECT_EQ(client.session.counters().sessions.value(), 1u);
  // A definition that does not come holds frames up for one wait only.
  client.push(natnet_face_frame(true, 11).datagram());
  changed.number = 12;
  client.push(changed.datagram());
  client.advance(251);
  client.push(natnet_face_frame(true, 13).datagram());
  EXPECT_EQ(client.last_frame().header.sequence, 13u);
}

TEST(NatnetSession, TheRecordingBitBecomesEvents) {
  Client client;
  client.connect();
  NatnetHandFrame recording = natnet_face_frame(true);
  recording.params = NatnetSuffix::kRecording;
  client.push(natnet_face_frame(true).datagram());
  client.push(recording.datagram());
  client.push(recording.datagram());
  client.push(natnet_face_frame(true).datagram());
  client.push(recording.datagram());
  client.push(test::natnet_message(9, {}).bytes());
  EXPECT_EQ(client.kinds(),
            (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame, Kind::kRecordingStarted, Kind::kFrame,
                         Kind::kFrame, Kind::kRecordingStopped, Kind::kFrame, Kind::kRecordingStarted, Kind::kFrame,
                         Kind::kRecordingStopped, Kind::kEndOfStream}));
}

TEST(NatnetSession, ASilentServerIsLostAndFoundAgain) {
  Client client;
  client.connect();
  client.push(natnet_face_frame(true).datagram());
  client.advance(999);
  EXPECT_NE(client.session.counters().link, LinkState::kLost);
  client.sent();
  client.advance(2);
  SourceEvent event;
  ASSERT_TRUE(client.session.pop(event));
  EXPECT_EQ(event.kind, Kind::kEndOfStream);
  EXPECT_EQ(client.session.counters().link, LinkState::kLost);
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect));
  client.push(natnet_face_frame(true).datagram());  // it may send on, but it has not said who it is
  EXPECT_EQ(client.session.counters().of(NatnetError::kNotConnected), 1u);
  client.events.clear();
  client.connect(3, 0);
  client.push(natnet_face_frame(false, 1).datagram());
  EXPECT_EQ(client.kinds(), (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame}));
  EXPECT_EQ(client.session.counters().reconnects.value(), 1u);
  EXPECT_EQ(client.session.counters().sessions.value(), 2u);
}

TEST(NatnetSession, AServerThatPausesButAnswersIsNotLost) {
  Client client;
  client.connect();
  client.push(natnet_face_frame(true).datagram());
  std::size_t keep_alives = 0;
  for (int s = 0; s < 20; ++s) {
    client.advance(500);
    for (const Bytes& datagram : client.sent()) {
      NatnetPacket packet;
      ASSERT_EQ(decode_natnet(datagram, packet), NatnetError::kNone);
      keep_alives += packet.message() == NatnetMessage::kKeepAlive ? 1 : 0;
      if (packet.message() != NatnetMessage::kEchoRequest) continue;
      HandPacket response;
      for (const std::byte b : packet.payload) response.put(b);
      client.push(test::natnet_message(13, response.u64(30'000'000)).bytes());
    }
  }
  EXPECT_EQ(client.session.counters().link, LinkState::kWaiting);
  EXPECT_EQ(client.session.counters().sessions.value(), 1u);
  EXPECT_NEAR(static_cast<double>(keep_alives), 10, 1);  // one a second
}

TEST(NatnetSession, AServerThatBeganAnewUnnoticedIsAskedAgainAndIsANewSession) {
  Client client;
  client.connect();
  client.push(natnet_face_frame(true, 50).datagram());
  for (int i = 0; i < 30; ++i) {  // it answers, but it does not know us
    client.advance(100);
    client.push(test::natnet_message(8, HandPacket().text("hello")).bytes());
    if (client.now_ns >= 1'000'000'000'000 + 1000 * kMs && client.has_sent(NatnetMessage::kConnect)) break;
    ASSERT_LT(i, 29);
  }
  client.push(natnet_server_info(4, 1));
  client.push(natnet_face_frame(true, 1).datagram());
  client.push(natnet_face_frame(true, 2).datagram());
  EXPECT_EQ(client.kinds(), (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame, Kind::kEndOfStream,
                                         Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame, Kind::kFrame}));
  // Far back at once is a new run too, but not again within a second; a little is the network.
  client.push(natnet_face_frame(true, 1000).datagram());
  client.push(natnet_face_frame(true, 3).datagram());
  EXPECT_EQ(client.session.counters().sessions.value(), 2u);
  client.now_ns += 1000 * kMs;
  client.push(natnet_face_frame(true, 1000).datagram());
  client.push(natnet_face_frame(true, 998).datagram());
  EXPECT_EQ(client.session.counters().sessions.value(), 2u);
  client.push(natnet_face_frame(true, 3).datagram());
  EXPECT_EQ(client.session.counters().sessions.value(), 3u);
}

TEST(NatnetSession, AServerThatIsBackAtOnceIsAskedWithinAQuarterOfASecond) {
  Client client;
  client.connect();
  client.push(natnet_face_frame(true, 500).datagram());
  client.sent();
  client.advance(240);
  EXPECT_FALSE(client.has_sent(NatnetMessage::kConnect));
  client.advance(20);
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect));
  client.advance(250);
  EXPECT_TRUE(client.has_sent(NatnetMessage::kConnect)) << "and again";
  client.push(natnet_server_info(4, 1));
  client.push(natnet_face_frame(true, 490).datagram());
  EXPECT_EQ(client.kinds(), (std::vector{Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame, Kind::kEndOfStream,
                                         Kind::kNewSession, Kind::kMarkerSet, Kind::kFrame}));
}

TEST(NatnetSession, AServerThatPausesIsAskedSeldomInTheEnd) {
  Client client;
  client.connect();
  client.push(natnet_face_frame(true, 1).datagram());
  const auto connects_in = [&](int seconds) {
    std::size_t connects = 0;
    for (int tenth = 0; tenth < 10 * seconds; ++tenth) {
      client.advance(100);
      client.push(test::natnet_message(8, HandPacket().text("hello")).bytes());
      connects += client.has_sent(NatnetMessage::kConnect) ? 1u : 0u;
    }
    return connects;
  };
  EXPECT_NEAR(static_cast<double>(connects_in(5)), 19, 2);  // four a second
  EXPECT_NEAR(static_cast<double>(connects_in(10)), 10, 2);
}

TEST(NatnetSession, ANumberThatStandsStillIsNoNewRun) {
  Client client;
  client.connect();
  for (int i = 0; i < 20; ++i) {
    client.now_ns += 400 * kMs;
    client.push(natnet_face_frame(true, 7).datagram());
  }
  EXPECT_EQ(client.session.counters().sessions.value(), 1u);
}

TEST(NatnetSession, ATimecodeThatNoClockShowsIsNone) {
  Client client;
  client.connect();
  NatnetHandFrame hand = natnet_face_frame(true);
  for (const std::uint32_t timecode : {0xFFFEFD00u, 0x18000000u, 0x013C0000u, 0x01003C00u, 0x0100001Eu}) {
    hand.timecode = timecode;
    client.push(hand.datagram());
    EXPECT_EQ(client.last_frame().header.timecode.frame_rate, 0) << timecode;
    EXPECT_EQ(client.last_frame().header.timecode.hours, 0) << timecode;
  }
  EXPECT_EQ(client.session.counters().extras[0].name, "impossible_timecodes");
  EXPECT_EQ(client.session.counters().extras[0].counter->value(), 5u);
}

TEST(NatnetSession, EchoesGiveClockSamples) {
  Client client;
  client.connect();
  client.advance(1);
  ClockSample sample;
  EXPECT_FALSE(client.session.pop_clock_sample(sample));
  std::uint64_t ticks = 0;
  for (const Bytes& datagram : client.sent()) {
    NatnetPacket packet;
    NatnetEcho echo;
    ASSERT_EQ(decode_natnet(datagram, packet), NatnetError::kNone);
    if (packet.message() == NatnetMessage::kEchoRequest) {
      ASSERT_EQ(decode_echo_request(packet.payload, echo), NatnetError::kNone);
      ticks = echo.client_ticks;
    }
  }
  client.now_ns += 300'000;
  client.push(test::natnet_message(13, HandPacket().u64(ticks + 1).u64(5)).bytes());  // not our echo
  EXPECT_FALSE(client.session.pop_clock_sample(sample));
  client.push(test::natnet_message(13, HandPacket().u64(ticks).u64(25'000'001)).bytes());
  ASSERT_TRUE(client.session.pop_clock_sample(sample));
  EXPECT_EQ(sample.sent_ns, static_cast<std::int64_t>(ticks));
  EXPECT_EQ(sample.tracker_ns, 2'500'000'100);
  EXPECT_EQ(sample.received_ns, client.now_ns);
}

TEST(NatnetSession, ReadsTimecodeWithAndWithoutDropFrames) {
  Client plain, drop(NatnetOptions{.timecode_rate = 25, .timecode_drop_frame = true});
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.timecode = 0x0A141E18;  // 10:20:30:24
  for (Client* client : {&plain, &drop}) {
    client->connect();
    client->push(hand.datagram());
    const Timecode& timecode = client->last_frame().header.timecode;
    EXPECT_EQ(timecode.hours, 10);
    EXPECT_EQ(timecode.minutes, 20);
    EXPECT_EQ(timecode.seconds, 30);
    EXPECT_EQ(timecode.frames, 24);
    EXPECT_EQ(timecode.drop_frame, client == &drop);
    EXPECT_EQ(timecode.frame_rate, client == &drop ? 25 : 30);
  }
  hand.timecode = 0x0A141E40 | 0x18;  // the flag of SMPTE 12M
  plain.push(hand.datagram());
  EXPECT_TRUE(plain.last_frame().header.timecode.drop_frame);
  EXPECT_EQ(plain.last_frame().header.timecode.frames, 24);
  hand.timecode = 0;
  plain.push(hand.datagram());
  EXPECT_EQ(plain.last_frame().header.timecode.frame_rate, 0);
}

TEST(NatnetSession, TakesTheTimestampWhereThereIsNoExposure) {
  Client client;
  client.connect();
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.ticks = 0;
  client.push(hand.datagram());
  EXPECT_EQ(client.last_frame().header.capture_time_ns, 1'500'000'000);
  hand.timestamp_s = 1e300;
  const std::size_t before = client.events.size();
  client.push(hand.datagram());
  EXPECT_EQ(client.events.size(), before);
  EXPECT_EQ(client.session.counters().of(NatnetError::kBadTime), 1u);
}

TEST(NatnetSession, NotFinitePositionsAreMissingAndCounted) {
  Client client;
  client.connect();
  NatnetHandFrame hand{.sized = true};
  hand.labelled = natnet_labelled(1, 1, std::numeric_limits<float>::quiet_NaN(), 1, 1, 10);
  hand.labelled_count = 1;
  client.push(hand.datagram());
  EXPECT_EQ(client.last_frame().state[0], MarkerState::kMissing);
  EXPECT_EQ(client.last_frame().reason[0], RejectReason::kNotFinite);
  EXPECT_EQ(client.session.counters().not_finite_markers.value(), 1u);
}

TEST(NatnetSession, UnitAndAxesCanBeOverridden) {
  Client client(NatnetOptions{.mm_per_unit = 10, .axes = *Axes::parse("LFU")});
  client.connect();
  client.push(natnet_face_frame(true).datagram());
  EXPECT_EQ(client.last_frame().position_mm[0], (Position{1, 3, 2}));
}

TEST(NatnetSession, WaitsForItsConsumerAndAllocatesNothingPerFrame) {
  Client client(NatnetOptions{.event_capacity = 8});
  client.connect();
  const Bytes datagram = natnet_face_frame(true).datagram();
  SourceEvent event;
  client.push(datagram);
  const auto before = test::allocations_of_this_thread();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(client.session.push(datagram, client.now_ns));
    ASSERT_TRUE(client.session.pop(event));
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  while (client.session.push(datagram, client.now_ns)) {
  }
  EXPECT_FALSE(client.session.ready());
  EXPECT_GE(client.session.counters().frames.held.value(), 3u);
}

TEST(NatnetSession, MutatedDatagramsNeverBreakItAndAlwaysBalance) {
  std::mt19937 random(7);
  const std::vector<Bytes> messages{natnet_face_frame(true).datagram(), natnet_face_frame(false).datagram(),
                                    natnet_two_faces(true).datagram(),  natnet_two_faces_model(),
                                    natnet_server_info(4, 1),           natnet_server_info(3, 0)};
  Client client;
  client.connect();
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = messages[random() % messages.size()];
    for (std::uint32_t n = random() % 4; n > 0; --n) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    if (random() % 8 == 0) bytes.resize(random() % (bytes.size() + 1));
    bytes.shrink_to_fit();
    client.push(bytes);
    client.advance(static_cast<std::int64_t>(random() % 20));
    client.sent();
    client.events.clear();
  }
  EXPECT_GT(client.session.counters().frames.emitted.value(), 1000u);
  EXPECT_GT(client.session.counters().datagrams.refused.value(), 1000u);
}

TEST(NatnetSession, NamesOptionsOutOfRange) {
  EXPECT_THROW(NatnetSession(NatnetOptions{.mm_per_unit = 0}), UserError);
  EXPECT_THROW(NatnetSession(NatnetOptions{.timecode_rate = 0}), UserError);
  EXPECT_THROW(NatnetSession(NatnetOptions{.event_capacity = 7}), UserError);
}

}  // namespace
}  // namespace risorius
