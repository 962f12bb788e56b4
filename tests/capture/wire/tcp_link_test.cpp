#include "capture/wire/tcp_link.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <gtest/gtest.h>

#include "support/hex.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using boost::asio::ip::tcp;
using test::run_until;
using Bytes = std::vector<std::byte>;

constexpr std::int64_t kMs = 1'000'000;

/// A link that notes what happens, and a server in the same io_context.
struct Linked {
  Linked() : acceptor(io, tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0)), server(io) {}
  void open(TcpLinkOptions options = {}) {
    options.host = "127.0.0.1";
    options.port = acceptor.is_open() ? acceptor.local_endpoint().port() : port;
    options.first_wait_ns = 2 * kMs;
    options.longest_wait_ns = 8 * kMs;
    link = std::make_unique<TcpLink>(io, options,
                                     TcpLink::Handlers{.connected = [this] { ++connected; },
                                                       .received =
                                                           [this](auto bytes, std::int64_t) {
                                                             const std::size_t use = std::min(bytes.size(), at_most);
                                                             heard.insert(heard.end(), bytes.begin(),
                                                                          bytes.begin() + static_cast<long>(use));
                                                             return use;
                                                           },
                                                       .round_done = [this] { return go_on; },
                                                       .lost = [this] { ++lost; }});
    link->start();
  }
  void accept() {
    bool accepted = false;
    acceptor.async_accept(server, [&](const auto& error) { accepted = !error; });
    ASSERT_TRUE(run_until(io, [&] { return accepted && link->connected(); }));
  }
  void say(const Bytes& bytes) { boost::asio::write(server, boost::asio::buffer(bytes)); }

  boost::asio::io_context io;
  tcp::acceptor acceptor;
  tcp::socket server;
  std::uint16_t port = 0;
  std::unique_ptr<TcpLink> link;
  int connected = 0, lost = 0;
  std::size_t at_most = 1000;
  bool go_on = true;
  Bytes heard;
};

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7);
  return bytes;
}

TEST(TcpLink, CarriesBytesBothWays) {
  Linked linked;
  linked.open();
  linked.accept();
  EXPECT_EQ(linked.connected, 1);
  EXPECT_EQ(linked.link->local_address(), "127.0.0.1");
  EXPECT_EQ(linked.link->peer_address(), "127.0.0.1");
  linked.say(counting(500));
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.heard.size() == 500; }));
  EXPECT_EQ(linked.heard, counting(500));
  linked.link->send(test::hex("010203"));
  Bytes answer(3);
  boost::asio::read(linked.server, boost::asio::buffer(answer));
  EXPECT_EQ(answer, test::hex("010203"));
}

TEST(TcpLink, OffersAgainWhatWasNotUsed) {
  Linked linked;
  linked.at_most = 7;
  linked.open();
  linked.accept();
  linked.say(counting(200));
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.heard.size() == 200; }));
  EXPECT_EQ(linked.heard, counting(200));
}

TEST(TcpLink, LeavesTheRestInTheKernelWhilePaused) {
  Linked linked;
  linked.at_most = 0;
  linked.go_on = false;
  linked.open({.read_buffer_bytes = 64});
  linked.accept();
  linked.say(counting(300));
  linked.io.restart();
  linked.io.run_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(linked.heard.empty());
  EXPECT_EQ(linked.lost, 0);
  linked.at_most = 1000;
  linked.go_on = true;
  linked.link->resume();
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.heard.size() == 300; }));
  EXPECT_EQ(linked.heard, counting(300));
}

TEST(TcpLink, ConnectsAgainWhenTheServerHasGone) {
  Linked linked;
  linked.open();
  linked.accept();
  linked.server.close();
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.lost == 1; }));
  EXPECT_FALSE(linked.link->connected());
  linked.accept();
  EXPECT_EQ(linked.connected, 2);
  EXPECT_EQ(linked.link->counters().connections.value(), 2u);
}

TEST(TcpLink, TriesUntilThereIsAServer) {
  Linked linked;
  linked.port = linked.acceptor.local_endpoint().port();
  linked.acceptor.close();
  linked.open();
  // 2 + 4 + 8 + 8 ms between five failures.
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.link->counters().failures.value() >= 5; }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(22));
  EXPECT_EQ(linked.connected, 0);
  EXPECT_EQ(linked.lost, 0) << "what never was is not lost";
  const tcp::endpoint endpoint(boost::asio::ip::address_v4::loopback(), linked.port);
  linked.acceptor.open(endpoint.protocol());
  linked.acceptor.set_option(tcp::acceptor::reuse_address(true));
  linked.acceptor.bind(endpoint);
  linked.acceptor.listen();
  linked.accept();
  EXPECT_EQ(linked.connected, 1);
}

TEST(TcpLink, GivesUpAServerThatTakesNothing) {
  Linked linked;
  linked.open({.write_queue_bytes = 1000});
  linked.accept();
  const Bytes much(1000);
  for (int i = 0; i < 100000 && linked.lost == 0; ++i) {
    linked.link->send(much);
    linked.io.restart();
    linked.io.poll();
  }
  EXPECT_EQ(linked.lost, 1);
}

TEST(TcpLink, DropsOnRequestAndStopsForGood) {
  Linked linked;
  linked.open();
  linked.accept();
  linked.link->drop();
  ASSERT_TRUE(run_until(linked.io, [&] { return linked.lost == 1; }));
  linked.server = tcp::socket(linked.io);
  linked.accept();
  linked.link->stop();
  linked.io.restart();
  linked.io.run_for(std::chrono::milliseconds(30));
  EXPECT_EQ(linked.lost, 1) << "no call after the stop";
  EXPECT_EQ(linked.connected, 2);
}

}  // namespace
}  // namespace risorius
