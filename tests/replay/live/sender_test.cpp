#include "replay/live/sender.h"

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <stdexcept>

#include "capture/errors.h"
#include "capture/wire/udp_source.h"
#include "capture/wire/zmq_source.h"
#include "support/allocation_counter.h"
#include "support/loopback.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

using test::marker_frame;
using test::marker_set;
using test::run_until;
using Kind = SourceEventKind;

std::vector<SourceEvent> pop_all(MarkerStreamDecoder& decoder) {
  std::vector<SourceEvent> events;
  for (SourceEvent event; decoder.pop(event);) events.push_back(event);
  return events;
}

// A source of either kind on a port that the system chose, and what it has received.
class Receiver {
 public:
  explicit Receiver(Transport transport) : transport_(transport) {
    if (transport == Transport::kUdp) {
      udp_.emplace(io_, UdpSourceOptions{.port = 0}, [this] { take(udp_->decoder()); });
      udp_->start();
    } else {
      zmq_.emplace(io_, ZmqSourceOptions{.endpoint = "tcp://127.0.0.1:*"}, [this] { take(zmq_->decoder()); });
      zmq_->start();
    }
  }
  SendTarget target() const {
    if (udp_) return {transport_, "127.0.0.1", udp_->port()};
    const std::string endpoint = zmq_->endpoint();
    return {transport_, "127.0.0.1", static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)))};
  }
  // What has come so far, so that the test needs no large receive buffer.
  void poll() {
    io_.restart();
    io_.poll();
  }
  bool run_to_end() {
    return run_until(io_, [this] { return !events.empty() && events.back().kind == Kind::kEndOfStream; });
  }
  MarkerStreamDecoder& decoder() { return udp_ ? udp_->decoder() : zmq_->decoder(); }

  std::vector<SourceEvent> events;

 private:
  void take(MarkerStreamDecoder& decoder) {
    for (auto& event : pop_all(decoder)) events.push_back(event);
  }

  Transport transport_;
  boost::asio::io_context io_;
  std::optional<UdpSource> udp_;
  std::optional<ZmqSource> zmq_;
};

class SenderTest : public testing::TestWithParam<Transport> {};

TEST_P(SenderTest, WhatIsReceivedEqualsWhatWasSentBitForBit) {
  Receiver receiver(GetParam());
  Sender sender(receiver.target());
  MarkerSet set = marker_set(130);
  set.mm_per_unit = 1000;  // of the file that the frames came from; frames themselves are always in mm and LUF
  set.axes = *Axes::parse("FLU");
  sender.send_marker_set(set);
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    sender.send_frame(marker_frame(sequence, 130));
    receiver.poll();
  }
  sender.send_end_of_stream();
  ASSERT_TRUE(receiver.run_to_end());
  ASSERT_EQ(receiver.events.size(), 203u);  // session, set, frames, end
  EXPECT_EQ(receiver.events[0].session, sender.session());
  EXPECT_EQ(receiver.events[1].set->names, set.names);
  EXPECT_EQ(receiver.events[1].set->mm_per_unit, 1);
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    EXPECT_TRUE(test::same_markers(receiver.events[2 + sequence].frame, marker_frame(sequence, 130)));
  }
  EXPECT_EQ(receiver.events.back().end.frames_sent, 200u);
  EXPECT_EQ(receiver.events.back().end.last_sequence, 199u);
  EXPECT_EQ(sender.statistics().frames, 200u);
  EXPECT_EQ(sender.statistics().send_errors, 0u);
}

TEST_P(SenderTest, RepeatsTheMarkerSetAheadOfFrames) {
  Receiver receiver(GetParam());
  Sender sender(receiver.target(), {.repeat_set_ns = 0});
  sender.send_marker_set(marker_set(5));
  for (std::uint64_t sequence = 0; sequence < 10; ++sequence) sender.send_frame(marker_frame(sequence, 5));
  sender.send_end_of_stream();
  ASSERT_TRUE(receiver.run_to_end());
  EXPECT_EQ(receiver.events.size(), 13u);  // session, set, frames, end: repetitions are no events
  EXPECT_GE(sender.statistics().datagrams, 22u);
}

INSTANTIATE_TEST_SUITE_P(Transports, SenderTest, testing::Values(Transport::kUdp, Transport::kZmqPush),
                         [](const auto& each) { return each.param == Transport::kUdp ? "Udp" : "Zmq"; });

TEST(Sender, ARedefinedSetIsTakenForANewOne) {
  Receiver receiver(Transport::kUdp);
  Sender sender(receiver.target());
  sender.send_marker_set(marker_set(3, 1, "a"));
  sender.send_marker_set(marker_set(3, 1, "b"));
  sender.send_marker_set(marker_set(3, 1, "b"));
  sender.send_end_of_stream();
  ASSERT_TRUE(receiver.run_to_end());
  ASSERT_EQ(receiver.events.size(), 4u);
  EXPECT_EQ(receiver.events[2].set->names[0], "b0");
  EXPECT_EQ(receiver.events[3].end.frames_sent, 0u);
}

TEST(Sender, ARefusedUdpPortIsCountedAndNotFatal) {
  SendTarget target;
  {
    Receiver gone(Transport::kUdp);
    target = gone.target();
  }
  Sender sender(target);
  sender.send_marker_set(marker_set(3));
  for (std::uint64_t sequence = 0; sequence < 10; ++sequence) sender.send_frame(marker_frame(sequence, 3));
  EXPECT_GT(sender.statistics().send_errors, 0u);
  EXPECT_EQ(sender.statistics().frames + sender.statistics().frames_not_sent, 10u);
}

TEST(Sender, AZmqReceiverThatTakesNothingIsTheUsersToSolve) {
  SendTarget target;
  {
    Receiver gone(Transport::kZmqPush);
    target = gone.target();
  }
  Sender sender(target, {.zmq_high_water_mark = 2, .give_up_after_ns = 20'000'000});
  const auto send_many = [&] {
    sender.send_marker_set(marker_set(3));
    for (std::uint64_t sequence = 0; sequence < 10; ++sequence) sender.send_frame(marker_frame(sequence, 3));
  };
  EXPECT_THROW(send_many(), UserError);
}

TEST(Sender, RefusesFramesThatAreNotOfTheSetInForce) {
  Receiver receiver(Transport::kUdp);
  Sender sender(receiver.target());
  EXPECT_THROW(sender.send_frame(marker_frame(0, 3)), std::invalid_argument);
  sender.send_marker_set(marker_set(3));
  EXPECT_THROW(sender.send_frame(marker_frame(0, 4)), std::invalid_argument);
  EXPECT_THROW(sender.send_frame(marker_frame(0, 3, 2)), std::invalid_argument);
  EXPECT_THROW(sender.send_marker_set(MarkerSet{.id = 1, .names = {"a", "a"}}), UserError);
  EXPECT_NO_THROW(sender.send_frame(marker_frame(0, 3)));
}

TEST(Sender, NamesWhatItCannotUse) {
  EXPECT_THROW(Sender({Transport::kUdp, "no such host", 7000}), UserError);
  EXPECT_THROW(Sender({Transport::kUdp, "127.0.0.1", 7000}, {.repeat_set_ns = -1}), UserError);
  EXPECT_THROW(Sender({Transport::kUdp, "127.0.0.1", 7000}, {.zmq_high_water_mark = 0}), UserError);
  EXPECT_THROW(Sender({Transport::kUdp, "127.0.0.1", 7000}, {.give_up_after_ns = 0}), UserError);
}

TEST(Sender, AllocatesNothingPerFrameOverUdp) {
  Receiver receiver(Transport::kUdp);
  Sender sender(receiver.target(), {.repeat_set_ns = 0});
  sender.send_marker_set(marker_set(60));
  const MarkerFrame frame = marker_frame(0, 60);
  const auto before = test::allocations_of_this_thread();
  for (int i = 0; i < 100; ++i) sender.send_frame(frame);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
