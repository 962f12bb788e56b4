// The NatNet server as a stranger meets it (packets written by hand), and our client against it over real sockets.
#include "replay/live/natnet_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <random>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/natnet_packets.h"
#include "capture/wire/natnet_source.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using test::HandPacket;
using test::natnet_message;
using test::NatnetHandModel;
using test::run_until;
using Bytes = std::vector<std::byte>;

MarkerSet face(std::size_t count = 3, double rate_hz = 120) {
  MarkerSet set{.rate_hz = rate_hz};
  for (std::size_t i = 0; i < count; ++i) set.names.push_back(fmt::format("m{}", i));
  return set;
}

/// Positions are multiples of 1/16 m: they survive metres in float bit for bit. Every fifth marker is missing.
MarkerFrame face_frame(std::uint64_t sequence, std::size_t count = 3) {
  MarkerFrame frame;
  frame.header.sequence = sequence;
  frame.header.capture_time_ns = static_cast<std::int64_t>(sequence) * 1'000'000;
  frame.count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    if ((sequence + i) % 5 == 4) continue;
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] = {62.5f * static_cast<float>(i + 1), -125, 62.5f * static_cast<float>(sequence % 16)};
  }
  return frame;
}

std::uint16_t port_of(const TrackerServer& server) {
  const std::string endpoint = server.endpoint();
  return static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
}

// A client that knows nothing of ours: a socket, and bytes.
class Stranger {
 public:
  explicit Stranger(boost::asio::io_context& io) : io_(io), socket_(io, {boost::asio::ip::address_v4::loopback(), 0}) {
    socket_.non_blocking(true);
  }
  void send(const NatnetServer& server, const HandPacket& datagram) {
    socket_.send_to(boost::asio::buffer(datagram.bytes()), {boost::asio::ip::address_v4::loopback(), port_of(server)});
  }
  /// The next datagram; empty if none comes.
  Bytes receive() {
    Bytes bytes(65536);
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(10)) {
      boost::system::error_code error;
      const std::size_t size = socket_.receive_from(boost::asio::buffer(bytes), from_, 0, error);
      if (!error) {
        bytes.resize(size);
        return bytes;
      }
      io_.restart();
      io_.run_one_for(std::chrono::milliseconds(10));
    }
    return {};
  }
  bool has_something() {
    io_.restart();
    io_.poll();
    return socket_.available() > 0;
  }
  Bytes ask(const NatnetServer& server, const HandPacket& datagram) {
    send(server, datagram);
    return receive();
  }
  std::uint16_t port() const { return socket_.local_endpoint().port(); }
  std::uint16_t from_port() const { return from_.port(); }

 private:
  boost::asio::io_context& io_;
  udp::socket socket_;
  udp::endpoint from_;
};

HandPacket request(std::string_view text) { return natnet_message(2, HandPacket().text(text)); }

struct Served {
  explicit Served(NatnetServerOptions options = {}) {
    options.command_port = 0;
    server.emplace(io, options);
    server->start(face());
  }
  boost::asio::io_context io;
  std::optional<NatnetServer> server;
};

TEST(NatnetServer, AnswersEveryFormOfConnect) {
  const HandPacket forms[]{HandPacket().u16(0).u16(0), natnet_message(0, HandPacket().text("Ping")),
                           natnet_message(0, HandPacket().text("Ping").zeros(259)),
                           natnet_message(0, HandPacket().text("Ping").zeros(266))};
  for (const HandPacket& form : forms) {
    Served served;
    Stranger stranger(served.io);
    const Bytes info = stranger.ask(*served.server, form);
    HandPacket expected;
    expected.text("Risorius").zeros(256 - 9).u8(0).u8(1).u8(0).u8(0).u8(4).u8(1).u8(0).u8(0);
    expected.u64(1'000'000'000).u16(1511).u8(0).zeros(4);
    EXPECT_EQ(info, natnet_message(1, expected).bytes());
    EXPECT_EQ(stranger.from_port(), port_of(*served.server));
    served.server->send_frame(face_frame(1), 5);
    EXPECT_EQ(stranger.receive().at(0), std::byte{7});
  }
}

TEST(NatnetServer, AnswersWhatClientsAskFor) {
  Served served;
  Stranger stranger(served.io);
  stranger.ask(*served.server, HandPacket().u16(0).u16(0));
  EXPECT_EQ(stranger.ask(*served.server, natnet_message(4, {})),
            NatnetHandModel{}.marker_set("face", {"m0", "m1", "m2"}).datagram());
  EXPECT_EQ(stranger.ask(*served.server, request("FrameRate")), natnet_message(3, HandPacket().f32({120})).bytes());
  EXPECT_EQ(stranger.ask(*served.server, request("UnitsToMillimeters")),
            natnet_message(3, HandPacket().f32({1000})).bytes());
  EXPECT_EQ(stranger.ask(*served.server, request("MakeCoffee")), natnet_message(100, {}).bytes());
  EXPECT_EQ(stranger.ask(*served.server, natnet_message(55, {})), natnet_message(100, {}).bytes());
  const std::int64_t before_ns = monotonic_now_ns();
  const Bytes echo = stranger.ask(*served.server, natnet_message(12, HandPacket().u64(77)));
  ASSERT_EQ(echo.size(), 20u);
  NatnetEcho ticks;
  ASSERT_EQ(decode_echo_response(std::span(echo).subspan(4), ticks), NatnetError::kNone);
  EXPECT_EQ(ticks.client_ticks, 77u);
  EXPECT_GE(static_cast<std::int64_t>(ticks.host_ticks), before_ns);
  EXPECT_LE(static_cast<std::int64_t>(ticks.host_ticks), monotonic_now_ns());
}

TEST(NatnetServer, SendsFramesOfTheVersionThatItsClientWants) {
  Served served;
  Stranger stranger(served.io), other(served.io);
  stranger.ask(*served.server, HandPacket().u16(0).u16(0));
  other.ask(*served.server, HandPacket().u16(0).u16(0));
  EXPECT_EQ(stranger.ask(*served.server, request("Bitstream,3.0")), natnet_message(3, HandPacket().i32(0)).bytes());
  EXPECT_EQ(stranger.ask(*served.server, request("Bitstream,9.9")), natnet_message(100, {}).bytes());
  for (const bool first : {true, false}) {
    served.server->send_frame(face_frame(4), 5);
    const Bytes old = stranger.receive(), current = other.receive();
    NatnetFrame frame;
    ASSERT_EQ(decode_frame(std::span(old).subspan(4), {3, 0}, frame), NatnetError::kNone);
    EXPECT_FALSE(frame.other_layout);
    EXPECT_EQ(frame.suffix.params, first ? NatnetSuffix::kBitstreamChanged : 0);
    EXPECT_EQ(frame.frame_number, 4);
    EXPECT_EQ(frame.suffix.mid_exposure_ticks, 5u);
    ASSERT_EQ(frame.labelled_count, 3u);
    EXPECT_EQ(labelled_marker(frame, 0).params, 0x09);  // occluded, has model
    EXPECT_EQ(labelled_marker(frame, 1).params, 0x0A);  // point cloud, has model
    EXPECT_EQ(labelled_marker(frame, 1).id, 0x10002);
    EXPECT_EQ(labelled_marker(frame, 1).x, 0.125f);
    ASSERT_EQ(decode_frame(std::span(current).subspan(4), {4, 1}, frame), NatnetError::kNone);
    EXPECT_FALSE(frame.other_layout);
    EXPECT_EQ(frame.suffix.params, 0);
  }
  EXPECT_EQ(served.server->statistics().frames_sent, 4u);
}

TEST(NatnetServer, ForgetsClientsThatLeaveOrSayNothing) {
  Served served({.client_timeout_ns = 50'000'000});
  Stranger leaves(served.io), silent(served.io);
  leaves.ask(*served.server, HandPacket().u16(0).u16(0));
  leaves.send(*served.server, natnet_message(9, {}));
  silent.ask(*served.server, HandPacket().u16(0).u16(0));
  EXPECT_FALSE(leaves.has_something());
  served.server->send_frame(face_frame(1), 5);
  EXPECT_FALSE(leaves.has_something());
  EXPECT_EQ(silent.receive().at(0), std::byte{7});
  const std::int64_t begin_ns = monotonic_now_ns();
  while (monotonic_now_ns() - begin_ns < 60'000'000) served.io.run_one_for(std::chrono::milliseconds(10));
  served.server->send_frame(face_frame(2), 5);
  EXPECT_FALSE(silent.has_something());
  EXPECT_EQ(served.server->statistics().frames_sent, 1u);
}

TEST(NatnetServer, SendsToTheDataPortOfItsClientsWhereThatIsTheConvention) {
  boost::asio::io_context io;
  Stranger data(io), command(io), second(io);
  NatnetServer server(io, {.command_port = 0, .data_port = data.port(), .to_data_port = true});
  server.start(face());
  command.ask(server, HandPacket().u16(0).u16(0));
  second.ask(server, HandPacket().u16(0).u16(0));
  server.send_frame(face_frame(1), 5);
  EXPECT_EQ(data.receive().at(0), std::byte{7});
  EXPECT_FALSE(command.has_something());
  EXPECT_FALSE(data.has_something());  // once, though there are two clients at this address
}

TEST(NatnetServer, SurvivesWhatIsNotNatnet) {
  Served served;
  Stranger stranger(served.io);
  for (const HandPacket& bytes : {HandPacket(), HandPacket().u8(1), natnet_message(12, HandPacket().u8(1)),
                                  HandPacket().u16(0).u16(99), natnet_message(2, HandPacket().u8('x'))})
    stranger.send(*served.server, bytes);
  EXPECT_EQ(stranger.ask(*served.server, natnet_message(0, {})).size() > 0, true);
  EXPECT_GE(served.server->statistics().refused_requests, 4u);
}

TEST(NatnetServer, NamesWhatCannotBe) {
  boost::asio::io_context io;
  EXPECT_THROW(NatnetServer(io, {.address = "nowhere", .command_port = 0}), UserError);
  EXPECT_THROW(NatnetServer(io, {.command_port = 0, .multicast_group = "127.0.0.1"}), UserError);
  EXPECT_THROW(NatnetServer(io, {.command_port = 0, .marker_set = ""}), UserError);
  NatnetServer first(io, {.command_port = 0});
  EXPECT_THROW(NatnetServer(io, {.command_port = port_of(first)}), UserError);
  for (const char* version : {"", "4", "2.9", "4.2", "4.x", "5.0", "3.0x"})
    EXPECT_THROW(parse_natnet_version(version), UserError) << version;
  EXPECT_EQ(parse_natnet_version("4.1.0.0"), (NatnetVersion{4, 1}));
}

// Our client against our server.

/// Each test has an address of its own: the protocol's data port is fixed, and tests may run at the same time.
std::string own_address() {
  const std::size_t hash = std::hash<std::string>()(testing::UnitTest::GetInstance()->current_test_info()->name());
  return fmt::format("127.77.{}.{}", hash % 250 + 1, hash / 250 % 250 + 1);
}

struct Connected {
  Connected(const NatnetServerOptions& options, NatnetSourceOptions client) {
    server.emplace(io, options);
    client.host = options.address;
    client.command_port = port_of(*server);
    client.local_address = own_address();
    client.session.first_wait_ns = 20'000'000;
    source.emplace(io, client, [this] { take(); });
  }
  void take() {
    for (SourceEvent event; source->pop(event);) {
      if (event.kind == SourceEventKind::kFrame) frames.push_back(event.frame);
      if (event.kind == SourceEventKind::kMarkerSet) sets.push_back(event.set);
      if (event.kind == SourceEventKind::kEndOfStream) ++ends;
    }
  }
  bool connect() {
    source->start();
    return run_until(io, [&] { return server->streaming_clients() > 0 && !sets.empty(); });
  }
  /// Frames [first, last), each while the client reads.
  bool play(std::uint64_t first, std::uint64_t last, std::size_t markers = 3) {
    const std::size_t expected = frames.size() + (last - first);
    for (std::uint64_t sequence = first; sequence < last; ++sequence) {
      server->send_frame(face_frame(sequence, markers), 1'000'000 * static_cast<std::int64_t>(sequence + 1));
      io.restart();
      io.poll();
    }
    return run_until(io, [&] { return frames.size() >= expected; });
  }
  void expect_frames(std::size_t markers = 3) {
    for (const MarkerFrame& frame : frames) {
      const MarkerFrame sent = face_frame(frame.header.sequence, markers);
      ASSERT_EQ(frame.count, sent.count);
      EXPECT_EQ(frame.state, sent.state);
      EXPECT_EQ(frame.position_mm, sent.position_mm);
    }
    EXPECT_TRUE(source->counters().datagrams.balanced());
    EXPECT_TRUE(source->counters().frames.balanced());
    EXPECT_EQ(source->counters().datagrams.refused.value(), 0u);
  }

  boost::asio::io_context io;
  std::optional<NatnetServer> server;
  std::optional<NatnetSource> source;
  std::vector<MarkerFrame> frames;
  std::vector<const MarkerSet*> sets;
  int ends = 0;
};

TEST(NatnetSource, ReceivesNamesAndEveryFrameInAllVersionsAtBothPorts) {
  for (const NatnetVersion version : {NatnetVersion{3, 0}, {3, 1}, {4, 0}, {4, 1}}) {
    for (const bool to_data_port : {false, true}) {
      NatnetServerOptions options{.command_port = 0, .to_data_port = to_data_port, .version = version};
      Connected both(options, {});
      both.server->start(face(165));  // frames of 6.4 kB: they travel in fragments
      ASSERT_TRUE(both.connect());
      EXPECT_EQ(both.sets.at(0)->names, face(165).names);
      EXPECT_EQ(both.sets.at(0)->rate_hz, 120);
      ASSERT_TRUE(both.play(0, 300, 165));
      both.expect_frames(165);
      ASSERT_EQ(both.frames.size(), 300u);
      EXPECT_EQ(both.frames[42].header.capture_time_ns, 43'000'000);
      EXPECT_EQ(both.source->counters().link, LinkState::kStreaming);
      EXPECT_GT(both.source->counters().granted_buffer_bytes.value(), 0u);
      ClockSample sample;
      ASSERT_TRUE(run_until(both.io, [&] { return both.source->pop_clock_sample(sample); }));
      EXPECT_LE(sample.sent_ns, sample.tracker_ns);  // one machine, one clock
      EXPECT_LE(sample.tracker_ns, sample.received_ns);
    }
  }
}

TEST(NatnetSource, PositionsTravelRoundedToMetresInFloat) {
  Connected both({.command_port = 0}, {});
  both.server->start(face());
  ASSERT_TRUE(both.connect());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> position_mm(-2000, 2000);
  std::vector<MarkerFrame> sent;
  for (std::uint64_t sequence = 0; sequence < 300; ++sequence) {
    MarkerFrame frame = face_frame(sequence);
    for (std::size_t i = 0; i < 3; ++i) {
      frame.state[i] = MarkerState::kMeasured;
      frame.position_mm[i] = {position_mm(random), position_mm(random), position_mm(random)};
    }
    sent.push_back(frame);
    both.server->send_frame(frame, 1);
    both.io.restart();
    both.io.poll();
  }
  ASSERT_TRUE(run_until(both.io, [&] { return both.frames.size() == sent.size(); }));
  std::size_t differ = 0;
  for (std::size_t f = 0; f < sent.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const float before = sent[f].position_mm[i].x, after = both.frames[f].position_mm[i].x;
      differ += before == after ? 0 : 1;
      // Two roundings, to metres and back, of at most half a unit in the last place: 2^-24 each.
      EXPECT_LE(std::abs(after - before), std::abs(before) * 0x1p-23f);
    }
  }
  EXPECT_GT(differ, 0u);  // else the bound says nothing
}

TEST(NatnetSource, FollowsAVersionThatChangesWhileFramesCome) {
  Connected both({.command_port = 0, .version = {3, 0}}, {});
  both.server->start(face());
  ASSERT_TRUE(both.connect());
  ASSERT_TRUE(both.play(0, 50));
  both.server->change_version({4, 1});
  ASSERT_TRUE(both.play(50, 100));
  both.server->change_version({4, 0});
  ASSERT_TRUE(both.play(100, 150));
  both.expect_frames();
  EXPECT_EQ(both.frames.size(), 150u);
  EXPECT_EQ(both.source->counters().sessions.value(), 1u);
}

TEST(NatnetSource, FindsAServerAgainThatStartsAnew) {
  Connected both({.command_port = 0}, {});
  const std::uint16_t port = port_of(*both.server);
  both.server->start(face());
  ASSERT_TRUE(both.connect());
  ASSERT_TRUE(both.play(0, 20));
  both.server.reset();
  ASSERT_TRUE(run_until(both.io, [&] { return both.ends == 1; }));
  EXPECT_EQ(both.source->counters().link, LinkState::kLost);
  both.server.emplace(both.io, NatnetServerOptions{.command_port = port, .version = {3, 0}});
  both.server->start(face());
  ASSERT_TRUE(run_until(both.io, [&] { return both.server->streaming_clients() > 0; }));
  ASSERT_TRUE(both.play(0, 20));
  EXPECT_EQ(both.frames.size(), 40u);
  EXPECT_EQ(both.source->counters().reconnects.value(), 1u);
  EXPECT_EQ(both.source->counters().sessions.value(), 2u);
  both.expect_frames();
}

TEST(NatnetSource, JoinsTheGroupThatTheServerNames) {
  {
    // A kernel without multicast on its loopback interface cannot run this test.
    boost::asio::io_context io;
    udp::socket probe(io, udp::v4());
    boost::system::error_code error;
    probe.set_option(boost::asio::ip::multicast::join_group(boost::asio::ip::make_address_v4("239.255.42.98"),
                                                            boost::asio::ip::address_v4::loopback()),
                     error);
    if (error) GTEST_SKIP() << "no multicast on loopback: " << error.message();
  }
  boost::asio::io_context ports;
  const std::uint16_t data_port =
      udp::socket(ports, {boost::asio::ip::address_v4::loopback(), 0}).local_endpoint().port();
  Connected both({.command_port = 0, .multicast_group = "239.255.42.98", .data_port = data_port}, {});
  both.server->start(face());
  ASSERT_TRUE(both.connect());
  ASSERT_TRUE(both.play(0, 50));
  both.expect_frames();
}

TEST(NatnetSource, RefusesDatagramsOfOthersThanItsServer) {
  Connected both({.address = "127.0.0.1", .command_port = 0}, {});
  both.server->start(face());
  ASSERT_TRUE(both.connect());
  // The data port is known to all: 1511 at our address.
  udp::socket intruder(both.io, {boost::asio::ip::make_address_v4("127.0.0.10"), 0});
  const Bytes forged = test::natnet_face_frame(true).datagram();
  intruder.send_to(boost::asio::buffer(forged), {boost::asio::ip::make_address_v4(own_address()), 1511});
  ASSERT_TRUE(run_until(both.io, [&] { return both.source->counters().of(NatnetError::kUnknownSender) == 1; }));
  EXPECT_TRUE(both.frames.empty());
}

TEST(NatnetSource, NamesWhatCannotBe) {
  boost::asio::io_context io;
  EXPECT_THROW(NatnetSource(io, {.host = "no.such.host.invalid"}, [] {}), UserError);
  EXPECT_THROW(NatnetSource(io, {.local_address = "203.0.113.1"}, [] {}), UserError);
  EXPECT_THROW(NatnetSource(io, {.multicast_group = "127.0.0.1"}, [] {}), UserError);
  EXPECT_THROW(NatnetSource(io, {.receive_buffer_bytes = 0}, [] {}), UserError);
}

TEST(NatnetSource, MayBeDestroyedWhileItWaits) {
  boost::asio::io_context io;
  {
    NatnetSource source(io, {.command_port = 9, .local_address = own_address()}, [] {});
    source.start();
    io.poll();
  }
  io.restart();
  io.run_for(std::chrono::milliseconds(10));
}

}  // namespace
}  // namespace risorius
