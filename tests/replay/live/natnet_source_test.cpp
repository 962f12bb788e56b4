// Our NatNet client against our server, over real sockets.
#include "capture/wire/natnet_source.h"

#include <array>
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
#include "capture/wire/natnet_packets.h"
#include "replay/live/natnet_face.h"
#include "replay/live/natnet_server.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using test::face;
using test::face_frame;
using test::port_of;
using test::run_until;
using Bytes = std::vector<std::byte>;

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

TEST(NatnetSource, RestsWhileItsDataPortIsFlooded) {
  Connected both({.command_port = 0, .to_data_port = true}, {});
  both.server->start(face(3));
  ASSERT_TRUE(both.connect());
  ASSERT_TRUE(both.play(0, 10));
  const SourceCounters& counters = both.source->counters();
  EXPECT_EQ(counters.rests.value(), 0u);
  boost::asio::io_context other_io;
  udp::socket other(other_io, udp::v4());
  const udp::endpoint target(boost::asio::ip::make_address(own_address()), kNatnetDataPort);
  const std::array<char, 40> garbage{};
  const std::uint64_t before = counters.datagrams.refused.value();
  for (int i = 0; i < 400; ++i) other.send_to(boost::asio::buffer(garbage), target);
  ASSERT_TRUE(run_until(both.io, [&] { return counters.datagrams.refused.value() == before + 400; }));
  EXPECT_EQ(counters.rests.value(), 3u);  // after turns of 128: 128, 256 and 384
  // Then it hears its server as before.
  ASSERT_TRUE(both.play(10, 20));
  EXPECT_EQ(counters.rests.value(), 3u);
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
