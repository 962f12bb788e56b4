// The servers as a client of another make would find them: plain POSIX sockets, bytes by hand.
#include <boost/asio/io_context.hpp>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <thread>

#include "capture/wire/qtm_settings.h"
#include "replay/live/qtm_request.h"
#include "replay/live/qtm_server.h"
#include "replay/live/vicon_server.h"
#include "replay/sample_take.h"
#include "support/hex.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using test::hex;
using test::operator+;
using Bytes = std::vector<std::byte>;

/// A plain client; the server runs in the same thread, while the client waits.
class Client {
 public:
  Client(boost::asio::io_context& io, std::uint16_t port) : io_(io), socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) ADD_FAILURE() << "cannot connect";
    ::fcntl(socket_, F_SETFL, O_NONBLOCK);
  }
  ~Client() { ::close(socket_); }
  /// From now on another thread has the server.
  void leave_the_server_alone() { drives_server_ = false; }
  void send(const Bytes& bytes) { EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), ssize_t(bytes.size())); }
  /// The next `size` bytes; fewer if the server closes or is silent for half a second.
  Bytes receive(std::size_t size) {
    Bytes bytes;
    for (int idle = 0; bytes.size() < size && idle < 500;) {
      Bytes some(size - bytes.size());
      const ssize_t got = ::recv(socket_, some.data(), some.size(), 0);
      if (got == 0) break;
      if (got > 0) {
        bytes.insert(bytes.end(), some.begin(), some.begin() + got);
      } else {
        idle += drive() ? 0 : 1;
      }
    }
    return bytes;
  }
  std::uint32_t receive_u32() {
    std::uint32_t value = 0;
    const Bytes bytes = receive(4);
    if (bytes.size() == 4) std::memcpy(&value, bytes.data(), 4);
    return value;
  }

 private:
  /// A millisecond of the server's time; false if it had nothing to do.
  bool drive() {
    if (!drives_server_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return false;
    }
    io_.restart();
    return io_.run_for(std::chrono::milliseconds(1)) > 0;
  }

  boost::asio::io_context& io_;
  bool drives_server_ = true;
  int socket_;
};

void run(boost::asio::io_context& io) {
  io.restart();
  io.run_for(std::chrono::milliseconds(30));
}

struct QtmClient : Client {
  using Client::Client;
  void say(std::string_view words) {
    ByteAppender out;
    append_qtm_text(QtmPacketType::kCommand, words, out);
    send({out.bytes().begin(), out.bytes().end()});
  }
  /// Type and body of the next packet.
  std::pair<std::uint32_t, Bytes> packet() {
    const std::uint32_t size = receive_u32();
    if (size < 8) return {99, {}};
    const std::uint32_t type = receive_u32();
    return {type, receive(size - 8)};
  }
  std::string reply(std::string_view words) {
    say(words);
    const auto [type, body] = packet();
    return std::to_string(type) + " " + std::string(qtm_text(body));
  }
};

struct QtmServing {
  QtmServing() : server(io, {.tcp = {.port = 0}, .newest_minor = 24}) { server.start(test::sample_set(3, 100)); }
  std::uint16_t port() const {
    const std::string url = server.endpoint();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  void play(std::uint64_t index) { server.send_frame(test::sample_frame(index, 3, 100), 0); }
  boost::asio::io_context io;
  QtmServer server;
};

TEST(QtmServer, AnswersAsQtmDoes) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  EXPECT_EQ(client.packet(),
            (std::pair<std::uint32_t, Bytes>{1, test::bytes_of({"QTM RT Interface connected\0", 27})}));
  EXPECT_EQ(client.reply("Version"), "1 Version is 1.1");
  EXPECT_EQ(client.reply("Version 1.25"), "0 Version NOT supported");
  EXPECT_EQ(client.reply("version 1.24"), "1 Version set to 1.24");
  EXPECT_EQ(client.reply("Version 2.0"), "0 Version NOT supported");
  EXPECT_EQ(client.reply("Version 1."), "0 Version NOT supported");
  EXPECT_EQ(client.reply("Version"), "1 Version is 1.24");
  EXPECT_EQ(client.reply("ByteOrder"), "1 Byte order is little endian");
  EXPECT_EQ(client.reply("Dance"), "0 Parse error");
  EXPECT_EQ(client.reply(""), "0 Parse error");
  EXPECT_EQ(client.reply("Start rtfromfile"), "0 You must be master to issue this command");
  EXPECT_EQ(client.reply("GetCaptureC3D"), "0 No capture to get");
  EXPECT_EQ(client.reply("QTMVersion"), "1 QTM Version is 0.1 (build 0)");  // the only form that clients can read
  EXPECT_EQ(client.reply("GetParameters"), "0 Parse error");
  EXPECT_EQ(client.reply("GetParameters 3D Nonsense"), "0 Parse error");
  EXPECT_EQ(client.reply("StreamFrames AllFrames"), "0 Parse error");
  EXPECT_EQ(client.reply("StreamFrames Frequency:0 3D"), "0 Parse error");
  EXPECT_EQ(client.reply("StreamFrames AllFrames 3D 4D"), "0 Parse error");
  client.say("GetState");
  EXPECT_EQ(client.packet(), (std::pair<std::uint32_t, Bytes>{6, hex("08")}));
  client.say("GetCurrentFrame 3D");
  EXPECT_EQ(client.packet().first, 4u) << "no frame yet: no more data";
  EXPECT_EQ(serving.server.statistics().refused_requests, 12u);
}

TEST(QtmServer, TellsLabelsAndRate) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  client.packet();
  client.say("GetParameters 3D");
  auto [type, body] = client.packet();
  EXPECT_EQ(type, 2u);
  EXPECT_EQ(body.back(), std::byte{0});
  auto settings = parse_qtm_settings(qtm_text(body));
  ASSERT_TRUE(settings && settings->labels);
  EXPECT_EQ(*settings->labels, (std::vector<std::string>{"marker 1", "marker 2", "marker 3"}));
  EXPECT_FALSE(settings->frequency_hz);
  client.say("GetParameters All");
  settings = parse_qtm_settings(qtm_text(client.packet().second));
  EXPECT_EQ(settings->frequency_hz, 100);
  EXPECT_TRUE(settings->labels);
}

TEST(QtmServer, SplitsHeadersAsTcpMay) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  client.packet();
  for (const std::byte one : hex("0C000000 01000000 566572 00")) client.send({one});  // "Ver"
  EXPECT_EQ(client.packet().first, 0u);
  // Two commands in one write.
  client.send(hex("10000000 01000000 56657273696F6E00") + hex("10000000 01000000 56657273696F6E00"));
  EXPECT_EQ(client.packet().first, 1u);
  EXPECT_EQ(client.packet().first, 1u);
  client.send(hex("FFFFFFFF 01000000"));
  EXPECT_TRUE(client.receive(1).empty()) << "closed";
  EXPECT_EQ(client.receive_u32(), 0u);
}

TEST(QtmServer, StreamsWhatWasAskedFor) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  client.packet();
  client.say("StreamFrames AllFrames 3DRes 3D");
  run(serving.io);
  EXPECT_EQ(serving.server.streaming_clients(), 1u);
  MarkerFrame frame = test::sample_frame(7, 3, 100);
  frame.state[1] = MarkerState::kMissing;
  serving.server.send_frame(frame, 0);
  const auto [type, body] = client.packet();
  ASSERT_EQ(type, 3u);
  QtmData data;
  ASSERT_EQ(decode_qtm_data(body, data), QtmError::kNone);
  EXPECT_EQ(data.timestamp_us, 70000u);
  EXPECT_EQ(data.frame, 7u);
  EXPECT_EQ(data.labelled->count, 3u);
  EXPECT_EQ(data.labelled->position(0),
            (std::array{frame.position_mm[0].x, frame.position_mm[0].y, frame.position_mm[0].z}));
  EXPECT_FALSE(data.labelled->position(1));
  // 8 + 16 bytes, 3D 16 + 3 * 12, 3DRes 16 + 3 * 16.
  EXPECT_EQ(body.size(), 16u + 52u + 64u);
  client.say("StreamFrames Stop");
  run(serving.io);
  serving.play(8);
  EXPECT_EQ(client.reply("Version"), "1 Version is 1.1") << "nothing in between";
}

TEST(QtmServer, StreamsEachClientAtItsRate) {
  QtmServing serving;  // 100 Hz
  QtmClient divided(serving.io, serving.port()), at_rate(serving.io, serving.port()), fast(serving.io, serving.port());
  for (QtmClient* client : {&divided, &at_rate, &fast}) client->packet();
  divided.say("StreamFrames FrequencyDivisor:4 3D");
  at_rate.say("StreamFrames Frequency:30 3D");
  fast.say("StreamFrames Frequency:1000 3D");
  run(serving.io);
  for (std::uint64_t i = 0; i < 100; ++i) serving.play(i);
  for (QtmClient* client : {&divided, &at_rate, &fast}) client->say("GetState");
  const auto frames_of = [](QtmClient& client) {
    std::vector<std::uint32_t> frames;
    for (auto packet = client.packet(); packet.first == 3; packet = client.packet()) {
      QtmData data;
      EXPECT_EQ(decode_qtm_data(packet.second, data), QtmError::kNone);
      frames.push_back(data.frame);
    }
    return frames;
  };
  const auto every_fourth = frames_of(divided);
  ASSERT_EQ(every_fourth.size(), 25u);
  EXPECT_EQ(every_fourth[1], 4u);
  EXPECT_NEAR(static_cast<double>(frames_of(at_rate).size()), 30, 1);
  EXPECT_EQ(frames_of(fast).size(), 100u);
}

TEST(QtmServer, TellsItsClientsThatLabelsHaveChanged) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  client.packet();
  client.say("StreamFrames AllFrames 3D");
  run(serving.io);
  serving.server.change_set(test::sample_set(4, 100));
  EXPECT_EQ(client.packet(), (std::pair<std::uint32_t, Bytes>{6, hex("0B")}));
  client.say("GetParameters 3D");
  EXPECT_EQ(parse_qtm_settings(qtm_text(client.packet().second))->labels->size(), 4u);
  serving.server.send_frame(test::sample_frame(1, 4, 100), 0);
  QtmData data;
  ASSERT_EQ(decode_qtm_data(client.packet().second, data), QtmError::kNone);
  EXPECT_EQ(data.labelled->count, 4u);
}

TEST(QtmServer, SendsFramesByUdp) {
  QtmServing serving;
  const int udp = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(udp, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  socklen_t size = sizeof own;
  ::getsockname(udp, reinterpret_cast<sockaddr*>(&own), &size);
  const std::string port = std::to_string(ntohs(own.sin_port));
  for (const std::string& where : {"UDP:" + port, "UDP:127.0.0.1:" + port}) {
    QtmClient client(serving.io, serving.port());
    client.packet();
    client.say("StreamFrames AllFrames " + where + " 3D");
    run(serving.io);
    serving.play(3);
    std::array<std::byte, 2000> buffer;
    pollfd readable{.fd = udp, .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&readable, 1, 1000), 1) << where;
    const ssize_t got = ::recv(udp, buffer.data(), buffer.size(), 0);
    QtmPacket packet;
    ASSERT_EQ(read_qtm_datagram(std::span(buffer).first(static_cast<std::size_t>(got)), packet), QtmError::kNone);
    EXPECT_EQ(packet.type, QtmPacketType::kData);
    EXPECT_EQ(client.reply("StreamFrames AllFrames UDP:0 3D"), "0 Parse error");
    EXPECT_EQ(client.reply("StreamFrames AllFrames UDP:nowhere.example:5 3D"), "0 Parse error");
  }
  ::close(udp);
}

TEST(QtmServer, SaysGoodBye) {
  QtmServing serving;
  QtmClient client(serving.io, serving.port());
  client.packet();
  client.say("StreamFrames AllFrames 3D");
  run(serving.io);
  serving.play(0);
  client.send(hex("0C000000 01000000"));  // the beginning of something, unread
  client.leave_the_server_alone();
  std::thread stopping([&] { serving.server.stop(); });
  std::vector<std::uint32_t> types;
  for (int i = 0; i < 4; ++i) {
    std::uint32_t type = 99;
    for (int tries = 0; type == 99 && tries < 3; ++tries) type = client.packet().first;
    types.push_back(type);
  }
  stopping.join();
  EXPECT_EQ(types, (std::vector<std::uint32_t>{3, 4, 6, 99}));
}

TEST(QtmServer, LetsNobodyWaitForAClientThatDoesNotRead) {
  QtmServing serving;
  QtmClient lazy(serving.io, serving.port()), good(serving.io, serving.port());
  lazy.packet();
  good.packet();
  lazy.say("StreamFrames AllFrames 3D");
  good.say("StreamFrames AllFrames 3D");
  run(serving.io);
  const auto before = std::chrono::steady_clock::now();
  std::uint64_t read = 0;
  for (std::uint64_t i = 0; i < 150000; ++i) {
    serving.play(i);
    if (i % 100 == 99) {
      for (int n = 0; n < 100; ++n) read += good.packet().first == 3 ? 1 : 0;
    }
  }
  EXPECT_EQ(read, 150000u);
  EXPECT_GT(serving.server.statistics().frames_not_sent, 0u);
  EXPECT_EQ(serving.server.statistics().frames_sent + serving.server.statistics().frames_not_sent, 300000u);
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(60));
}

TEST(QtmRequest, ReadsRatesAddressesAndComponents) {
  const auto request =
      parse_qtm_stream_request(qtm_words("StreamFrames FrequencyDivisor:3 UDP:10.0.0.7:4545 3dNOLABELS "
                                         "6DEuler Analog:1-3 TimeCode"),
                               1);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->rate, QtmStreamRequest::Rate::kDivisor);
  EXPECT_EQ(request->rate_argument, 3u);
  EXPECT_EQ(request->udp_address, "10.0.0.7");
  EXPECT_EQ(request->udp_port, 4545);
  EXPECT_TRUE(request->components.unlabelled && request->components.timecode);
  EXPECT_FALSE(request->components.markers);
  const auto all = parse_qtm_stream_request(qtm_words("StreamFrames AllFrames All"), 1);
  ASSERT_TRUE(all);
  EXPECT_TRUE(all->components.markers && all->components.unlabelled && all->components.timecode);
  for (const char* bad : {"s", "s AllFrames", "s Frequency:x 3D", "s Frequency:-1 3D", "s AllFrames UDP:70000 3D",
                          "s AllFrames UDP:x 3D", "s Sometimes 3D"}) {
    EXPECT_FALSE(parse_qtm_stream_request(qtm_words(bad), 1)) << bad;
  }
}

struct ViconClient : Client {
  using Client::Client;
  /// The objects of the next packet; empty also for a packet of length 0.
  std::vector<std::pair<std::uint32_t, Bytes>> packet() {
    EXPECT_EQ(receive_u32(), kViconTag);
    const Bytes body = receive(receive_u32());
    std::vector<std::pair<std::uint32_t, Bytes>> objects;
    std::span<const std::byte> rest = body;
    ViconObject object;
    while (!rest.empty() && take_vicon_object(rest, object))
      objects.emplace_back(object.id, Bytes(object.body.begin(), object.body.end()));
    return objects;
  }
  std::vector<std::uint32_t> ids() {
    std::vector<std::uint32_t> ids;
    for (const auto& [id, body] : packet()) ids.push_back(id);
    return ids;
  }
  void want(std::vector<std::uint32_t> ids) {
    ByteAppender out;
    ViconPacketWriter writer(out);
    writer.ids(ViconId::kObjectEnums, ids);
    writer.finish();
    send({out.bytes().begin(), out.bytes().end()});
  }
};

const Bytes kPush = hex("01002B1A 09000000 A2860100 01000000 01");
const Bytes kPull = hex("01002B1A 09000000 A2860100 01000000 00");
using Ids = std::vector<std::uint32_t>;

// Not in the initialiser itself: g++ 12 then warns of its own string.
ViconServerOptions vicon_options(bool y_up) {
  ViconServerOptions options;
  options.tcp.port = 0;
  options.y_up = y_up;
  return options;
}

struct ViconServing {
  explicit ViconServing(bool y_up = false) : server(io, vicon_options(y_up)) { server.start(test::sample_set(3, 120)); }
  std::uint16_t port() const {
    const std::string url = server.endpoint();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  void play(std::uint64_t index) { server.send_frame(test::sample_frame(index, 3), 0); }
  boost::asio::io_context io;
  ViconServer server;
};

TEST(ViconServer, GreetsWithWhatItHas) {
  ViconServing serving;
  ViconClient client(serving.io, serving.port());
  const auto greeting = client.packet();
  ASSERT_EQ(greeting.size(), 1u);
  EXPECT_EQ(greeting[0].first, 100001u);
  const auto ids = decode_vicon_ids(greeting[0].second);
  for (const std::uint32_t id : {1U, 2U, 5U, 6U, 7U, 42U}) EXPECT_TRUE(ids->contains(id)) << id;
}

TEST(ViconServer, TakesThePushBeforeAnythingElse) {
  // The official client's order: it asks for 6 only after it has received something.
  ViconServing serving;
  ViconClient client(serving.io, serving.port());
  client.send(kPush);
  client.packet();
  run(serving.io);
  serving.play(0);
  EXPECT_EQ(client.ids(), Ids{}) << "an empty packet: nothing is wanted yet";
  client.want({1, 2, 5});
  run(serving.io);
  serving.play(1);
  EXPECT_EQ(client.ids(), (Ids{1, 2, 5}));
  client.want({1, 2, 5, 6, 7, 26, 37, 39, 100004, 4711});
  run(serving.io);
  serving.play(2);
  const auto objects = client.packet();
  ASSERT_EQ(objects.size(), 8u);
  EXPECT_EQ(decode_vicon_i64(objects[0].second), 1125000);
  const auto subject = decode_vicon_subject(objects[1].second);
  ASSERT_TRUE(subject);
  EXPECT_EQ(subject->markers[2].name, "marker 3");
  EXPECT_EQ(objects[3].first, 5u);
  EXPECT_EQ(decode_vicon_u32(objects[3].second), 2u);
}

TEST(ViconServer, LeavesOccludedMarkersOutAndTurnsAxes) {
  for (const bool y_up : {false, true}) {
    ViconServing serving(y_up);
    ViconClient client(serving.io, serving.port());
    client.packet();
    client.want({2, 5, 6});
    client.send(kPush);
    run(serving.io);
    MarkerFrame frame = test::sample_frame(1, 3);
    frame.state[0] = MarkerState::kMissing;
    frame.position_mm[1] = {1, 2, 3};  // left, up, front
    serving.server.send_frame(frame, 0);
    const auto objects = client.packet();
    ASSERT_EQ(objects.size(), 3u);
    const auto recons = decode_vicon_recons(objects[2].second, true);
    ASSERT_EQ(recons->count, 2u);
    EXPECT_EQ((*recons)[0].subject, decode_vicon_subject(objects[0].second)->id);
    EXPECT_EQ((*recons)[0].marker, decode_vicon_subject(objects[0].second)->markers[1].id);
    EXPECT_EQ((*recons)[0].position_mm, y_up ? (std::array<double, 3>{3, 2, -1}) : (std::array<double, 3>{3, 1, 2}));
  }
}

TEST(ViconServer, AnswersPullsOneByOne) {
  ViconServing serving;
  ViconClient client(serving.io, serving.port());
  client.packet();
  client.want({5});
  client.send(kPull);
  run(serving.io);
  serving.play(1);  // the first that there is
  EXPECT_EQ(client.ids(), Ids{5});
  serving.play(2);  // not asked for
  client.send(kPull);
  auto objects = client.packet();  // the latest, at once
  EXPECT_EQ(decode_vicon_u32(objects.at(0).second), 2u);
  client.send(hex("01002B1A 0C000000 A8860100 04000000 02000000"));  // the next two
  run(serving.io);
  for (const std::uint64_t index : {3U, 4U, 5U}) serving.play(index);
  EXPECT_EQ(decode_vicon_u32(client.packet().at(0).second), 3u);
  EXPECT_EQ(decode_vicon_u32(client.packet().at(0).second), 4u);
  client.send(hex("01002B1A 10000000 2A000000 08000000 0700000000000000"));
  EXPECT_EQ(client.ids(), Ids{42}) << "no fifth frame before the echo";
}

TEST(ViconServer, EchoesAPingAtOnce) {
  ViconServing serving;
  ViconClient client(serving.io, serving.port());
  client.packet();
  const Bytes ping = hex("01002B1A 10000000 2A000000 08000000 1122334455667788");
  client.send(ping);
  EXPECT_EQ(client.receive(ping.size()), ping);
  // An object that nobody knows, a keep-alive and an empty packet are no reason to leave.
  client.send(hex("01002B1A 0A000000 77777777 02000000 ABCD") + hex("01002B1A 08000000 A3860100 00000000") +
              hex("01002B1A 00000000") + ping);
  EXPECT_EQ(client.receive(ping.size()), ping);
  client.send(hex("02002B1A 00000000"));
  EXPECT_TRUE(client.receive(1).empty()) << "closed for a wrong tag";
}

TEST(ViconServer, LetsNobodyWaitForAClientThatDoesNotRead) {
  ViconServing serving;
  ViconClient lazy(serving.io, serving.port());
  lazy.packet();
  lazy.want({1, 2, 5, 6});
  lazy.send(kPush);
  run(serving.io);
  for (std::uint64_t i = 0; i < 30000; ++i) serving.play(i);
  EXPECT_GT(serving.server.statistics().frames_not_sent, 0u);
  EXPECT_EQ(serving.server.streaming_clients(), 1u);
}

}  // namespace
}  // namespace risorius
