// The NatNet server as a stranger meets it: requests and expected answers are written by hand.
#include "replay/live/natnet_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <gtest/gtest.h>
#include <optional>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/natnet_packets.h"
#include "replay/live/natnet_face.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using test::face;
using test::face_frame;
using test::HandPacket;
using test::natnet_message;
using test::NatnetHandModel;
using test::port_of;
using Bytes = std::vector<std::byte>;

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
  EXPECT_EQ(stranger.ask(*served.server, request("LiveMode")), natnet_message(3, HandPacket().i32(0)).bytes());
  EXPECT_EQ(stranger.ask(*served.server, request("SetPlaybackLooping,1")),
            natnet_message(3, HandPacket().i32(0)).bytes());
  EXPECT_EQ(stranger.ask(*served.server, request("Bitstream")),
            natnet_message(3, HandPacket().text("Bitstream,4.1")).bytes());
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

TEST(NatnetServer, FramesComeFromTheDataPortThatItTells) {
  Served served({.data_port = 0});
  Stranger stranger(served.io);
  const Bytes info = stranger.ask(*served.server, HandPacket().u16(0).u16(0));
  NatnetServerInfo told;
  ASSERT_EQ(decode_server_info(std::span(info).subspan(4), told), NatnetError::kNone);
  EXPECT_NE(told.data_port, 0);
  EXPECT_NE(told.data_port, port_of(*served.server));
  served.server->send_frame(face_frame(1), 5);
  ASSERT_EQ(stranger.receive().at(0), std::byte{7});
  EXPECT_EQ(stranger.from_port(), told.data_port);
  EXPECT_EQ(served.server->data_port_problem(), "");
}

TEST(NatnetServer, SendsFromTheCommandPortWhereAnotherHasTheDataPort) {
  boost::asio::io_context io;
  Stranger owner(io), stranger(io);  // the owner does not share its port
  NatnetServer server(io, {.command_port = 0, .data_port = owner.port()});
  EXPECT_NE(server.data_port_problem(), "");
  server.start(face());
  stranger.ask(server, HandPacket().u16(0).u16(0));
  server.send_frame(face_frame(1), 5);
  ASSERT_EQ(stranger.receive().at(0), std::byte{7});
  EXPECT_EQ(stranger.from_port(), port_of(server));
}

TEST(NatnetServer, ConnectMayAskForAVersionOfTheBitStream) {
  for (const auto& [major, minor, given] :
       {std::tuple{3, 1, NatnetVersion{3, 1}}, {2, 9, NatnetVersion{3, 0}}, {9, 0, NatnetVersion{4, 1}}}) {
    Served served;
    Stranger stranger(served.io);
    HandPacket sender;
    sender.text("client")
        .zeros(264 - 7)
        .u8(0)
        .u8(static_cast<std::uint8_t>(major))
        .u8(static_cast<std::uint8_t>(minor));
    const Bytes info = stranger.ask(*served.server, natnet_message(0, sender.zeros(2)));
    NatnetServerInfo told;
    ASSERT_EQ(decode_server_info(std::span(info).subspan(4), told), NatnetError::kNone);
    EXPECT_EQ(told.version, given);
    served.server->send_frame(face_frame(4), 5);
    const Bytes bytes = stranger.receive();
    NatnetFrame frame;
    ASSERT_EQ(decode_frame(std::span(bytes).subspan(4), given, frame), NatnetError::kNone);
    EXPECT_FALSE(frame.other_layout);
  }
}

TEST(NatnetServer, WaitsNotForeverForAClientThatNeverAsksForTheModel) {
  Served served;
  Stranger stranger(served.io);
  stranger.ask(*served.server, HandPacket().u16(0).u16(0));
  EXPECT_EQ(served.server->streaming_clients(), 0u) << "it may still ask";
  const std::int64_t begin_ns = monotonic_now_ns();
  while (served.server->streaming_clients() == 0 && monotonic_now_ns() - begin_ns < 20'000'000'000) {
    served.io.restart();
    served.io.run_one_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(served.server->streaming_clients(), 1u);
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

TEST(NatnetServer, AClientThatFellSilentBeforeTheFirstFrameIsNotWaitedFor) {
  Served served({.client_timeout_ns = 2'000'000'000});
  Stranger silent(served.io);
  silent.ask(*served.server, HandPacket().u16(0).u16(0));
  const auto becomes = [&](std::size_t clients) {
    const std::int64_t begin_ns = monotonic_now_ns();
    while (served.server->streaming_clients() != clients && monotonic_now_ns() - begin_ns < 20'000'000'000) {
      served.io.restart();
      served.io.run_one_for(std::chrono::milliseconds(10));
    }
    return served.server->streaming_clients() == clients;
  };
  EXPECT_TRUE(becomes(1));
  EXPECT_TRUE(becomes(0));
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

}  // namespace
}  // namespace risorius
