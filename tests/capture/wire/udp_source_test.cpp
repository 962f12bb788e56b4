#include "capture/wire/udp_source.h"

#include <boost/asio/io_context.hpp>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <sstream>

#include "capture/errors.h"
#include "support/allocation_counter.h"
#include "support/loopback.h"
#include "support/native_stream.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::datagrams_of;
using test::LoopbackUdp;
using test::marker_frame;
using test::marker_set;
using test::run_until;

// A source whose events are collected.
struct Receiver {
  explicit Receiver(UdpSourceOptions options = {}) {
    options.port = 0;
    source.emplace(io, options, [this] { take(); });
    source->start();
  }
  void take() {
    for (SourceEvent event; source->decoder().pop(event);) {
      if (event.kind == SourceEventKind::kMarkerSet) sets.push_back(event.set);
      if (event.kind == SourceEventKind::kFrame) frames.push_back(event.frame);
      if (event.kind == SourceEventKind::kEndOfStream) ends.push_back(event.end);
    }
  }
  bool run_until_received(std::uint64_t datagrams) {
    return run_until(io, [&] { return source->decoder().counters().datagrams.received.value() >= datagrams; });
  }

  boost::asio::io_context io;
  std::optional<UdpSource> source;
  std::vector<const MarkerSet*> sets;
  std::vector<MarkerFrame> frames;
  std::vector<EndOfStream> ends;
};

TEST(UdpSource, ReceivesWhatWasSent) {
  // 201 datagrams of 0.5 kB: within the buffer that a system grants by default, more than one wake-up may take.
  Receiver receiver({.decoder = {.stream_id = 3}});
  LoopbackUdp udp(receiver.source->port());
  std::uint64_t sent = 0;
  for (const auto& datagram : datagrams_of(marker_set(40))) sent += udp.send(datagram) ? 1 : 0;
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    sent += udp.send(datagrams_of(marker_frame(sequence, 40)).at(0)) ? 1 : 0;
  }
  ASSERT_TRUE(receiver.run_until_received(sent));
  ASSERT_EQ(receiver.sets.size(), 1u);
  ASSERT_EQ(receiver.frames.size(), 200u);
  std::int64_t before_ns = 1;
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    EXPECT_TRUE(test::same_markers(receiver.frames[sequence], marker_frame(sequence, 40)));
    EXPECT_EQ(receiver.frames[sequence].header.stream_id, 3u);
    EXPECT_GE(receiver.frames[sequence].header.receive_time_ns, before_ns);
    before_ns = receiver.frames[sequence].header.receive_time_ns;
  }
  EXPECT_EQ(receiver.source->counters().kernel_drops.value(), 0u);
  // One callback for many datagrams, bounded so that others get their turn.
  EXPECT_LT(receiver.source->counters().wake_ups.value(), sent / 32);
  EXPECT_GT(receiver.source->counters().wake_ups.value(), 1u);
}

TEST(UdpSource, CountsWhatTheKernelDropped) {
  Receiver receiver({.receive_buffer_bytes = 4096});
  LoopbackUdp udp(receiver.source->port());
  std::uint64_t sent = 0;
  for (const auto& datagram : datagrams_of(marker_set(60))) sent += udp.send(datagram) ? 1 : 0;
  for (std::uint64_t sequence = 0; sequence < 100; ++sequence) {
    sent += udp.send(datagrams_of(marker_frame(sequence, 60)).at(0)) ? 1 : 0;
  }
  receiver.io.restart();
  while (receiver.io.poll_one() > 0 && receiver.frames.empty()) {
  }
  // The count comes with the next datagram that is received.
  sent += udp.send(datagrams_of(marker_frame(100, 60)).at(0)) ? 1 : 0;
  ASSERT_TRUE(run_until(receiver.io,
                        [&] { return !receiver.frames.empty() && receiver.frames.back().header.sequence == 100; }));
  EXPECT_GT(receiver.source->counters().kernel_drops.value(), 0u);
  EXPECT_EQ(receiver.source->decoder().counters().datagrams.received.value() +
                receiver.source->counters().kernel_drops.value(),
            sent);
}

TEST(UdpSource, RefusesAndCountsDatagramsThatAreTooLong) {
  Receiver receiver;
  LoopbackUdp udp(receiver.source->port());
  udp.send(test::Bytes(0));
  udp.send(test::Bytes(1473));
  udp.send(test::Bytes(5000));
  ASSERT_TRUE(receiver.run_until_received(3));
  EXPECT_EQ(receiver.source->decoder().counters().of(DecodeError::kTooShort), 1u);
  EXPECT_EQ(receiver.source->decoder().counters().of(DecodeError::kTooLong), 2u);
  EXPECT_EQ(receiver.source->counters().truncated.value(), 1u);
}

TEST(UdpSource, PausesWhenItsConsumerIsFullAndLosesNothing) {
  boost::asio::io_context io;
  UdpSource source(io, {.port = 0, .decoder = {.event_capacity = 8}}, [] {});
  source.start();
  LoopbackUdp udp(source.port());
  for (const auto& datagram : datagrams_of(marker_set(5))) udp.send(datagram);
  for (std::uint64_t sequence = 0; sequence < 20; ++sequence) udp.send(datagrams_of(marker_frame(sequence, 5)).at(0));
  std::vector<std::uint64_t> sequences;
  while (sequences.size() < 20) {
    ASSERT_TRUE(run_until(io, [&] {
      return source.counters().pauses.value() > 0 || source.decoder().counters().datagrams.received.value() == 21;
    }));
    for (SourceEvent event; source.decoder().pop(event);) {
      if (event.kind == SourceEventKind::kFrame) sequences.push_back(event.frame.header.sequence);
    }
    source.resume();
    io.restart();
    io.poll();
  }
  EXPECT_GT(source.counters().pauses.value(), 1u);
  for (std::uint64_t i = 0; i < 20; ++i) EXPECT_EQ(sequences[i], i);
}

TEST(UdpSource, ABusyPortIsTheUsersToSolve) {
  Receiver first;
  const std::string place = "udp://127.0.0.1:" + std::to_string(first.source->port());
  try {
    UdpSource second(first.io, {.port = first.source->port()}, [] {});
    FAIL() << "two sources on " << place;
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("another port"), std::string::npos) << error.what();
  }
}

TEST(UdpSource, NamesOptionsOutOfRange) {
  boost::asio::io_context io;
  EXPECT_THROW(UdpSource(io, {.address = "localhost.", .port = 0}, [] {}), UserError);
  EXPECT_THROW(UdpSource(io, {.address = "203.0.113.1", .port = 0}, [] {}), UserError);  // of no machine (RFC 5737)
  EXPECT_THROW(UdpSource(io, {.port = 0, .receive_buffer_bytes = 0}, [] {}), UserError);
}

TEST(UdpSource, MayBeDestroyedWhileItWaits) {
  boost::asio::io_context io;
  int calls = 0;
  {
    UdpSource source(io, {.port = 0}, [&] { ++calls; });
    source.start();
    io.poll();
    LoopbackUdp udp(source.port());
    udp.send(test::Bytes(10));
  }
  io.restart();
  io.poll();
  EXPECT_EQ(calls, 0);
}

TEST(UdpSource, AllocatesNothingPerFrame) {
  boost::asio::io_context io;
  std::uint64_t frames = 0;
  SourceEvent event;
  UdpSource* receiving = nullptr;
  UdpSource source(io, {.port = 0}, [&] {
    while (receiving->decoder().pop(event)) frames += event.kind == SourceEventKind::kFrame ? 1 : 0;
  });
  receiving = &source;
  source.start();
  LoopbackUdp udp(source.port());
  std::vector<test::Bytes> datagrams = datagrams_of(marker_set(60));
  for (std::uint64_t sequence = 0; sequence < 60; ++sequence) {
    datagrams.push_back(datagrams_of(marker_frame(sequence, 60)).at(0));
  }
  const auto run = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      udp.send(datagrams[i]);
      while (source.decoder().counters().datagrams.received.value() <= i) io.run_one();
    }
  };
  run(0, 10);  // Asio keeps the memory of its handlers
  const auto before = test::allocations_of_this_thread();
  run(10, datagrams.size());
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_EQ(frames, 60u);
}

TEST(UdpSource, RestsWhileItIsFloodedWithGarbageAndWakesToWhatIsOfUse) {
  Receiver receiver({.receive_buffer_bytes = 1 << 20});
  LoopbackUdp udp(receiver.source->port());
  const SourceCounters& counters = receiver.source->counters();
  const test::Bytes garbage(40, std::byte{0xab});
  std::uint64_t sent = 0;
  // Turns of 128 with nothing in them but garbage: as many rests, each longer than the last.
  const auto flood = [&](std::uint64_t datagrams) {
    for (std::uint64_t i = 0; i < datagrams; ++i) sent += udp.send(garbage) ? 1 : 0;
  };
  flood(400);
  ASSERT_TRUE(receiver.run_until_received(sent));
  EXPECT_EQ(counters.of(DecodeError::kBadMagic), 400u);
  EXPECT_EQ(counters.rests.value(), 3u);  // after 128, 256 and 384
  // What is of use among it is found, and nothing rests after a turn with something of use.
  flood(50);
  for (const auto& datagram : datagrams_of(marker_set(40))) sent += udp.send(datagram) ? 1 : 0;
  for (std::uint64_t sequence = 0; sequence < 300; ++sequence)
    sent += udp.send(datagrams_of(marker_frame(sequence, 40)).at(0)) ? 1 : 0;
  ASSERT_TRUE(receiver.run_until_received(sent));
  EXPECT_EQ(receiver.frames.size() + counters.kernel_drops.value(), 300u);
  EXPECT_EQ(counters.rests.value(), 3u);
}

// The example in capture/README.md, run as it stands there.
TEST(UdpSource, ReceivesTheExampleSenderOfTheReadme) {
  if (std::system("python3 -c '' > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
  std::ifstream file(std::string(RISORIUS_SOURCE_DIR) + "/capture/README.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::string readme = text.str();
  const std::string opening = "```python\n";
  const auto begin = readme.find(opening);
  ASSERT_NE(begin, std::string::npos);
  const auto end = readme.find("```", begin + opening.size());
  ASSERT_NE(end, std::string::npos);
  const std::string code = readme.substr(begin + opening.size(), end - begin - opening.size());
  EXPECT_LE(std::count(code.begin(), code.end(), '\n'), 15);
  test::TemporaryFolder folder;
  const auto script = folder.path() / "sender.py";
  std::ofstream(script) << code;

  Receiver receiver;
  const std::string command = "python3 " + script.string() + " " + std::to_string(receiver.source->port());
  ASSERT_EQ(std::system(command.c_str()), 0) << code;
  ASSERT_TRUE(run_until(receiver.io, [&] { return !receiver.ends.empty(); }));
  ASSERT_EQ(receiver.sets.size(), 1u);
  EXPECT_EQ(receiver.sets[0]->names, (std::vector<std::string>{"chin", "nose"}));
  EXPECT_EQ(receiver.sets[0]->rate_hz, 60);
  ASSERT_EQ(receiver.frames.size(), receiver.ends[0].frames_sent);
  ASSERT_EQ(receiver.frames.size(), 60u);
  for (std::size_t i = 0; i < receiver.frames.size(); ++i) {
    const MarkerFrame& frame = receiver.frames[i];
    EXPECT_EQ(frame.header.sequence, i);
    ASSERT_EQ(frame.count, 2u);
    EXPECT_EQ(frame.state[0], MarkerState::kMeasured);
    EXPECT_EQ(frame.position_mm[0], (Position{0, -40 - static_cast<float>(i), 10}));
    EXPECT_EQ(frame.position_mm[1], (Position{0, 20, 30}));
  }
  EXPECT_EQ(receiver.source->decoder().counters().datagrams.refused.value(), 0u);
}

}  // namespace
}  // namespace risorius
