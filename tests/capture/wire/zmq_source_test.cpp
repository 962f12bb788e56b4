#include "capture/wire/zmq_source.h"

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <zmq.hpp>

#include "capture/errors.h"
#include "support/loopback.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

constexpr std::size_t kPrefix = std::string_view("zmq+").size();

using test::Bytes;
using test::datagrams_of;
using test::marker_frame;
using test::marker_set;
using test::run_until;

const std::string kAnyPort = "tcp://127.0.0.1:*";

void send(zmq::socket_t& socket, const std::vector<Bytes>& messages) {
  for (const auto& message : messages) ASSERT_TRUE(socket.send(zmq::buffer(message), zmq::send_flags::none));
}

TEST(ZmqSource, TakesEverythingFromAPushingSenderThatIsFasterThanItself) {
  boost::asio::io_context io;
  std::vector<MarkerFrame> frames;
  ZmqSource* receiving = nullptr;
  ZmqSource source(io, {.endpoint = kAnyPort, .high_water_mark = 10, .decoder = {.event_capacity = 8}}, [&] {
    for (SourceEvent event; receiving->decoder().pop(event);) {
      if (event.kind == SourceEventKind::kFrame) frames.push_back(event.frame);
    }
  });
  receiving = &source;
  source.start();
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push);
  push.connect(source.endpoint().substr(kPrefix));
  send(push, datagrams_of(marker_set(60)));
  for (std::uint64_t sequence = 0; sequence < 900; ++sequence) send(push, datagrams_of(marker_frame(sequence, 60)));
  ASSERT_TRUE(run_until(io, [&] { return frames.size() == 900; }));
  for (std::uint64_t sequence = 0; sequence < 900; ++sequence) {
    ASSERT_TRUE(test::same_markers(frames[sequence], marker_frame(sequence, 60)));
  }
  // Edges of ZMQ_FD are not lost either when the queue has run empty in between.
  for (std::uint64_t sequence = 900; sequence < 950; ++sequence) {
    send(push, datagrams_of(marker_frame(sequence, 60)));
    ASSERT_TRUE(run_until(io, [&] { return frames.size() == sequence + 1; }));
  }
}

TEST(ZmqSource, PausesWhenItsConsumerIsFullAndLosesNothing) {
  boost::asio::io_context io;
  ZmqSource source(io, {.endpoint = kAnyPort, .decoder = {.event_capacity = 8}}, [] {});
  source.start();
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push);
  push.connect(source.endpoint().substr(kPrefix));
  send(push, datagrams_of(marker_set(5)));
  for (std::uint64_t sequence = 0; sequence < 40; ++sequence) send(push, datagrams_of(marker_frame(sequence, 5)));
  std::uint64_t expected = 0;
  while (expected < 40) {
    const auto pauses = source.counters().pauses.value();
    ASSERT_TRUE(run_until(io, [&] {
      return source.counters().pauses.value() > pauses || source.decoder().counters().datagrams.received.value() == 41;
    }));
    for (SourceEvent event; source.decoder().pop(event);) {
      if (event.kind == SourceEventKind::kFrame) {
        EXPECT_EQ(event.frame.header.sequence, expected++);
      }
    }
    source.resume();
  }
  EXPECT_GT(source.counters().pauses.value(), 1u);
}

TEST(ZmqSource, SubscribesToAPublisher) {
  zmq::context_t context;
  zmq::socket_t publisher(context, zmq::socket_type::xpub);
  publisher.bind(kAnyPort);
  boost::asio::io_context io;
  std::uint64_t frames = 0;
  ZmqSource* receiving = nullptr;
  const ZmqSourceOptions options{
      .endpoint = publisher.get(zmq::sockopt::last_endpoint), .pattern = ZmqPattern::kSubscribe, .connect = true};
  ZmqSource source(io, options, [&] {
    for (SourceEvent event; receiving->decoder().pop(event);) frames += event.kind == SourceEventKind::kFrame ? 1 : 0;
  });
  receiving = &source;
  source.start();
  zmq::message_t subscription;
  ASSERT_TRUE(publisher.recv(subscription));  // from now on nothing is lost
  send(publisher, datagrams_of(marker_set(5)));
  for (std::uint64_t sequence = 0; sequence < 10; ++sequence) send(publisher, datagrams_of(marker_frame(sequence, 5)));
  EXPECT_TRUE(run_until(io, [&] { return frames == 10; }));
}

TEST(ZmqSource, RefusesAndCountsMessagesThatAreTooLong) {
  boost::asio::io_context io;
  ZmqSource source(io, {.endpoint = kAnyPort}, [] {});
  source.start();
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push);
  push.connect(source.endpoint().substr(kPrefix));
  send(push, {Bytes(0), Bytes(1473), Bytes(60000)});
  ASSERT_TRUE(run_until(io, [&] { return source.decoder().counters().datagrams.received.value() == 3; }));
  EXPECT_EQ(source.decoder().counters().of(DecodeError::kTooLong), 2u);
  EXPECT_EQ(source.counters().truncated.value(), 1u);
}

TEST(ZmqSource, ABusyPortOrABadEndpointIsTheUsersToSolve) {
  boost::asio::io_context io;
  ZmqSource first(io, {.endpoint = kAnyPort}, [] {});
  try {
    ZmqSource second(io, {.endpoint = first.endpoint().substr(kPrefix)}, [] {});
    FAIL() << "two sources on " << first.endpoint().substr(kPrefix);
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find(first.endpoint().substr(kPrefix)), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("another port"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ZmqSource(io, {.endpoint = "7001"}, [] {}), UserError);
  EXPECT_THROW(ZmqSource(io, {.endpoint = kAnyPort, .high_water_mark = 0}, [] {}), UserError);
}

TEST(ZmqSource, WithCurveOnlyListedKeysGetThroughAndTheOthersAreCounted) {
  boost::asio::io_context io;
  const CurveKeyPair ours = make_curve_key_pair(), known = make_curve_key_pair(), unknown = make_curve_key_pair();
  ZmqSource source(io, {.endpoint = kAnyPort, .curve = {.keys = ours, .clients = {known.public_key}}}, [] {});
  source.start();
  zmq::context_t context;
  const auto pushing = [&](std::optional<CurveClient> curve) {
    zmq::socket_t push(context, zmq::socket_type::push);
    push.set(zmq::sockopt::linger, 0);
    push.set(zmq::sockopt::reconnect_ivl, -1);  // one try, so that they can be counted
    if (curve) use_curve(push, *curve);
    push.connect(source.endpoint().substr(kPrefix));
    // Without waiting: a socket that was refused already has nobody to send to, and none will come.
    for (const auto& message : datagrams_of(marker_set(5))) {
      (void)push.send(zmq::buffer(message), zmq::send_flags::dontwait);
    }
    return push;
  };
  const auto& counters = source.counters();
  const auto refused = [&](std::uint64_t count) {
    return run_until(io, [&] { return counters.refused_connections.value() >= count; });
  };
  {
    const auto stranger = pushing(CurveClient{unknown, ours.public_key});
    ASSERT_TRUE(refused(1)) << "a key that is not listed";
    const auto plain = pushing(std::nullopt);
    ASSERT_TRUE(refused(2)) << "no key";
    const auto misled = pushing(CurveClient{known, unknown.public_key});
    ASSERT_TRUE(refused(3)) << "another server's key";
  }
  EXPECT_EQ(counters.datagrams.received.value(), 0u);
  const auto friendly = pushing(CurveClient{known, ours.public_key});
  ASSERT_TRUE(run_until(io, [&] { return counters.datagrams.received.value() == 1; }));
  EXPECT_EQ(counters.refused_connections.value(), 3u);
}

TEST(ZmqSource, WithCurveAndNoListWhoeverKnowsTheServersKeyGetsThrough) {
  boost::asio::io_context io;
  const CurveKeyPair ours = make_curve_key_pair();
  ZmqSource source(io, {.endpoint = kAnyPort, .curve = {.keys = ours, .clients = {}}}, [] {});
  source.start();
  zmq::context_t context;
  zmq::socket_t push(context, zmq::socket_type::push);
  use_curve(push, {make_curve_key_pair(), ours.public_key});
  push.connect(source.endpoint().substr(kPrefix));
  send(push, datagrams_of(marker_set(5)));
  ASSERT_TRUE(run_until(io, [&] { return source.counters().datagrams.received.value() == 1; }));
  EXPECT_EQ(source.counters().refused_connections.value(), 0u);
}

TEST(ZmqSource, MayBeDestroyedWhileItWaits) {
  boost::asio::io_context io;
  {
    ZmqSource source(io, {.endpoint = kAnyPort}, [] {});
    source.start();
    io.poll();
  }
  io.restart();
  io.poll();
}

}  // namespace
}  // namespace risorius
