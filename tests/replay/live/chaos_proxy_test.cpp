#include "replay/live/chaos_proxy.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "capture/wire/receive_batch.h"
#include "support/loopback.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

/// A sender and a receiver with the proxy between them, and what came through.
struct Line {
  explicit Line(const ChaosOptions& options) : receiver(io, {boost::asio::ip::address_v4::loopback(), 0}) {
    prepare_receive_buffer(receiver.native_handle(), 1 << 20);
    const SendTarget to{.host = "127.0.0.1", .port = receiver.local_endpoint().port()};
    proxy.emplace(io, parse_listen_address("udp://127.0.0.1:0"), to, options);
    proxy->start();
    const std::string endpoint = proxy->endpoint();
    sender.emplace(parse_send_target(endpoint).port);
  }
  std::vector<test::Bytes> send(const std::vector<test::Bytes>& datagrams) {
    for (const auto& datagram : datagrams) {
      sender->send(datagram);
      // One at a time, so that no socket's buffer overflows.
      test::run_until(io, [&, before = proxy->counts().received] { return proxy->counts().received > before; });
    }
    proxy->stop();
    std::vector<test::Bytes> received;
    receiver.non_blocking(true);
    for (test::Bytes bytes(65536);;) {
      boost::system::error_code error;
      const std::size_t size = receiver.receive(boost::asio::buffer(bytes), 0, error);
      if (error) return received;
      received.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  boost::asio::io_context io;
  boost::asio::ip::udp::socket receiver;
  std::optional<ChaosProxy> proxy;
  std::optional<test::LoopbackUdp> sender;
};

std::vector<test::Bytes> numbered(std::size_t count) {
  std::vector<test::Bytes> datagrams;
  for (std::size_t i = 0; i < count; ++i) datagrams.emplace_back(20, static_cast<std::byte>(i));
  return datagrams;
}

TEST(ChaosProxy, WithoutFaultsPassesAllAsItCame) {
  Line line({});
  const auto sent = numbered(200);
  EXPECT_EQ(line.send(sent), sent);
  EXPECT_EQ(line.proxy->counts().forwarded, 200u);
  EXPECT_EQ(line.proxy->counts().not_native, 200u);
}

TEST(ChaosProxy, CountsWhatItDid) {
  Line line({.loss = 0.2, .reorder = 0.1, .duplicate = 0.1, .corrupt = 0.1, .seed = 3});
  const auto sent = numbered(250);
  const auto received = line.send(sent);
  const ChaosCounts& counts = line.proxy->counts();
  EXPECT_EQ(received.size(), counts.forwarded);
  EXPECT_EQ(counts.received, 250u);
  EXPECT_EQ(counts.forwarded, counts.received - counts.lost + counts.duplicated);
  std::size_t unknown = 0, overtaken = 0;
  int newest = -1;
  for (const auto& datagram : received) {
    const auto place = std::find(sent.begin(), sent.end(), datagram);
    if (place == sent.end()) {
      ++unknown;
      continue;
    }
    overtaken += place - sent.begin() < newest ? 1 : 0;
    newest = std::max(newest, static_cast<int>(place - sent.begin()));
  }
  EXPECT_EQ(unknown, counts.corrupted);
  EXPECT_GT(counts.corrupted, 0u);
  EXPECT_GT(counts.lost, 0u);
  // Those that were corrupted too cannot be told here.
  EXPECT_LE(overtaken, counts.overtaken);
  EXPECT_GT(overtaken, 0u);
}

TEST(ChaosProxy, SendsWhatNothingOvertakesAfterAWhile) {
  Line line({.reorder = 1});
  line.sender->send(numbered(1)[0]);
  EXPECT_TRUE(test::run_until(line.io, [&] { return line.proxy->counts().forwarded == 1; }));
  EXPECT_EQ(line.proxy->counts().overtaken, 0u);
}

TEST(ChaosProxy, DelaysAndStillSendsAll) {
  Line line({.delay_ns = 3'000'000, .jitter_ns = 5'000'000});
  EXPECT_EQ(line.send(numbered(100)).size(), 100u);
  EXPECT_GT(line.proxy->counts().overtaken, 0u);
}

TEST(ChaosProxy, RefusesOtherTransports) {
  boost::asio::io_context io;
  EXPECT_THROW(
      ChaosProxy(io, parse_listen_address("zmq+tcp://127.0.0.1:0"), parse_send_target("udp://127.0.0.1:7000"), {}),
      UserError);
}

}  // namespace
}  // namespace risorius
