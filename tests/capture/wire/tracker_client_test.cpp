#include "capture/wire/tracker_client.h"

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cstring>
#include <gtest/gtest.h>

#include "capture/wire/qtm_session.h"
#include "support/hex.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using boost::asio::ip::tcp;
using boost::asio::ip::udp;
using test::run_until;
using Bytes = std::vector<std::byte>;

Bytes text(QtmPacketType type, std::string_view words) {
  ByteAppender out;
  append_qtm_text(type, words, out);
  return {out.bytes().begin(), out.bytes().end()};
}

Bytes frame(std::uint32_t number) {
  ByteAppender out;
  const std::vector<std::optional<std::array<float, 3>>> positions(1, std::array<float, 3>{1, 2, 3});
  append_qtm_data(std::uint64_t{number} * 10000, number, {.markers = true}, positions, {}, out);
  return {out.bytes().begin(), out.bytes().end()};
}

// More than one turn of receiving takes: the connection has its turn in between.
constexpr std::uint32_t kBurst = 600;

/// A server by hand: says what QTM says, in one breath, because a client may not rely on pauses.
struct ByHand {
  ByHand() : acceptor(io, tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0)), server(io) {}
  void open(bool udp_frames) {
    TrackerClientOptions options{.url = "qtm://test", .udp_frames = udp_frames};
    options.link.host = "127.0.0.1";
    options.link.port = acceptor.local_endpoint().port();
    options.link.first_wait_ns = 1'000'000;
    client = std::make_unique<TrackerClient>(
        io, options,
        std::make_unique<QtmSession>(QtmSessionOptions{.tracker = {.event_capacity = 16}, .label_prefix = ""}), [this] {
          if (pops) take();
        });
    client->start();
  }
  void take() {
    for (SourceEvent event; client->pop(event);) {
      kinds += "NSFE()"[static_cast<int>(event.kind)];
      last = event.frame.header.sequence;
    }
  }
  /// Where the client wants its frames.
  udp::endpoint datagrams_to() const {
    const auto at = stream_command.find("UDP:");
    EXPECT_NE(at, std::string::npos) << stream_command;
    return {boost::asio::ip::address_v4::loopback(),
            static_cast<std::uint16_t>(std::stoi(stream_command.substr(at + 4)))};
  }
  /// kBurst frames in its socket's buffer, before it can read one.
  void burst() {
    udp::socket sender(io, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0));
    for (std::uint32_t i = 1; i <= kBurst; ++i) sender.send_to(boost::asio::buffer(frame(i)), datagrams_to());
  }
  void accept() {
    bool accepted = false;
    acceptor.async_accept(server, [&](const auto& error) { accepted = !error; });
    ASSERT_TRUE(run_until(io, [&] { return accepted; }));
    say(text(QtmPacketType::kCommand, "QTM RT Interface connected"));
    EXPECT_EQ(hear(), "Version 1.27");
    say(text(QtmPacketType::kCommand, "Version set to 1.27"));
    EXPECT_EQ(hear(), "GetState");
    say(test::hex("09000000 06000000 01"));
    EXPECT_EQ(hear(), "GetParameters General");
    say(text(QtmPacketType::kXml, "<Q><General><Frequency>100</Frequency></General></Q>"));
    EXPECT_EQ(hear(), "GetParameters 3D");
    say(text(QtmPacketType::kXml, "<Q><The_3D><Label><Name>chin</Name></Label></The_3D></Q>"));
    stream_command = hear();
  }
  void say(const Bytes& bytes) { boost::asio::write(server, boost::asio::buffer(bytes)); }
  /// The next command of the client.
  std::string hear() {
    Bytes header(8), body;
    EXPECT_TRUE(run_until(io, [&] { return server.available() >= 8; }));
    boost::asio::read(server, boost::asio::buffer(header));
    std::uint32_t size = 0;
    std::memcpy(&size, header.data(), 4);
    body.resize(size - 8);
    EXPECT_TRUE(run_until(io, [&] { return server.available() >= body.size(); }));
    boost::asio::read(server, boost::asio::buffer(body));
    return std::string(qtm_text(body));
  }

  boost::asio::io_context io;
  tcp::acceptor acceptor;
  tcp::socket server;
  std::unique_ptr<TrackerClient> client;
  std::string kinds, stream_command;
  std::uint64_t last = 0;
  bool pops = true;
};

TEST(TrackerClient, TakesMoreFramesAtOnceThanItHasRoomFor) {
  ByHand by_hand;
  by_hand.open(false);
  by_hand.accept();
  Bytes many;
  for (std::uint32_t number = 1; number <= 500; ++number) {
    const Bytes one = frame(number);
    many.insert(many.end(), one.begin(), one.end());
  }
  by_hand.say(many);
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 500; }));
  EXPECT_EQ(by_hand.kinds, "NS" + std::string(500, 'F'));
  EXPECT_TRUE(by_hand.client->keeps_order());
  EXPECT_EQ(by_hand.client->endpoint(), "qtm://test");
}

TEST(TrackerClient, EndsTheStreamAndConnectsAgain) {
  ByHand by_hand;
  by_hand.open(false);
  by_hand.accept();
  by_hand.say(frame(1));
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 1; }));
  by_hand.server.close();
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.kinds == "NSFE"; }));
  EXPECT_EQ(by_hand.client->counters().link, LinkState::kLost);
  by_hand.accept();
  by_hand.say(frame(1));
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.kinds == "NSFENSF"; }));
  EXPECT_EQ(by_hand.client->counters().reconnects.value(), 1u);
  EXPECT_EQ(by_hand.client->counters().link, LinkState::kStreaming);
}

TEST(TrackerClient, AnEndDoesNotOvertakeTheDatagramsBeforeIt) {
  ByHand by_hand;
  by_hand.open(true);
  by_hand.accept();
  by_hand.burst();
  by_hand.say(text(QtmPacketType::kNoMoreData, ""));
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.kinds.ends_with('E'); }));
  EXPECT_EQ(by_hand.kinds, "NS" + std::string(kBurst, 'F') + "E");
}

TEST(TrackerClient, TakesTheDatagramsThatCameBeforeTheConnectionWasLost) {
  ByHand by_hand;
  by_hand.open(true);
  by_hand.accept();
  by_hand.burst();
  by_hand.server.close();
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.kinds.ends_with('E'); }));
  EXPECT_EQ(by_hand.kinds, "NS" + std::string(kBurst, 'F') + "E");
}

TEST(TrackerClient, PausesTheConnectionUntilThereIsRoomForTheDatagramsBeforeIt) {
  ByHand by_hand;
  by_hand.open(true);
  by_hand.accept();
  by_hand.pops = false;
  by_hand.burst();
  by_hand.say(text(QtmPacketType::kNoMoreData, ""));
  by_hand.io.restart();
  by_hand.io.run_for(std::chrono::milliseconds(100));
  ASSERT_EQ(by_hand.kinds, "");
  by_hand.pops = true;
  by_hand.take();
  by_hand.client->resume();
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.kinds.ends_with('E'); }));
  EXPECT_EQ(by_hand.kinds, "NS" + std::string(kBurst, 'F') + "E");
}

TEST(TrackerClient, TakesDatagramsOfItsServerAlone) {
  ByHand by_hand;
  by_hand.open(true);
  by_hand.accept();
  EXPECT_FALSE(by_hand.client->keeps_order());
  const udp::endpoint to = by_hand.datagrams_to();
  udp::socket own(by_hand.io, udp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0));
  udp::socket other(by_hand.io, udp::endpoint(boost::asio::ip::make_address("127.0.0.9"), 0));
  other.send_to(boost::asio::buffer(frame(6)), to);
  own.send_to(boost::asio::buffer(frame(7)), to);
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 7; }));
  EXPECT_EQ(by_hand.kinds, "NSF");
  EXPECT_EQ(by_hand.client->counters().foreign.value(), 1u);
}

TEST(TrackerClient, RestsWhileItsUdpPortIsFlooded) {
  ByHand by_hand;
  by_hand.open(true);
  by_hand.accept();
  const SourceCounters& counters = by_hand.client->counters();
  udp::socket own(by_hand.io, udp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0));
  udp::socket other(by_hand.io, udp::endpoint(boost::asio::ip::make_address("127.0.0.9"), 0));
  own.send_to(boost::asio::buffer(frame(1)), by_hand.datagrams_to());
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 1; }));
  EXPECT_EQ(counters.rests.value(), 0u);
  // With room for two packets at a time a turn is of 16: three turns of garbage, of the server's and of others.
  const std::array<char, 40> garbage{};
  for (int i = 0; i < 25; ++i) {
    own.send_to(boost::asio::buffer(garbage), by_hand.datagrams_to());
    other.send_to(boost::asio::buffer(garbage), by_hand.datagrams_to());
  }
  const auto useless = [&] { return counters.datagrams.refused.value() + counters.foreign.value(); };
  ASSERT_TRUE(run_until(by_hand.io, [&] { return useless() == 50; }));
  EXPECT_EQ(counters.rests.value(), 3u);
  own.send_to(boost::asio::buffer(frame(2)), by_hand.datagrams_to());
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 2; }));
  EXPECT_EQ(counters.rests.value(), 3u);
}

TEST(TrackerClient, GivesOnAHeldFrameInTime) {
  ByHand by_hand;
  by_hand.open(false);
  by_hand.accept();
  by_hand.say(frame(1));
  // The timecode of frame 1, too late, in a packet of its own: frame 2 waits for its own, which never comes.
  by_hand.say(
      test::hex("30000000 03000000 1027000000000000 01000000 01000000"
                "18000000 11000000 01000000 00000000 00000000 00000000"));
  by_hand.say(frame(2));
  ASSERT_TRUE(run_until(by_hand.io, [&] { return by_hand.last == 2; }));
  EXPECT_EQ(by_hand.kinds, "NSFF");
}

}  // namespace
}  // namespace risorius
