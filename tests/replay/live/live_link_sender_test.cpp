#include "replay/live/live_link_sender.h"

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "capture/wire/udp_source.h"
#include "support/live_link_csv_file.h"
#include "support/loopback.h"
#include "support/test_data.h"

namespace risorius {
namespace {

TEST(LiveLinkSender, WhatItSendsArrivesByNameAndNumber) {
  test::TemporaryFolder folder;
  test::write_live_link_csv(folder.path() / "face.csv", {.frames = 70, .lost = {3}, .without_face = {5}});
  const LiveLinkTake take = load_live_link_csv(folder.path() / "face.csv");
  boost::asio::io_context io;
  LiveLinkSource source(io, {.port = 0}, [] {});
  source.start();
  LiveLinkSender sender(io, take, {.port = source.port(), .first_frame = 1000});
  LiveLinkTiming timing("face.csv", take);
  sender.start(timing.info().markers);
  MarkerFrame frame;
  while (timing.next(frame)) sender.send_frame(frame, 0);
  timing.rewind();
  ASSERT_TRUE(timing.next(frame));
  frame.header.sequence = 70;  // the first of the next round
  sender.send_frame(frame, 0);
  EXPECT_EQ(sender.statistics().frames_sent, 70u);
  ASSERT_TRUE(test::run_until(io, [&] { return source.counters().datagrams.received.value() == 70; }));

  std::vector<ShapeFrame> frames;
  for (SourceEvent event; source.pop(event);) {
    if (event.kind == SourceEventKind::kShapes) frames.push_back(event.shapes);
  }
  ASSERT_EQ(frames.size(), 70u);
  EXPECT_EQ(source.endpoint(), "livelink://127.0.0.1:" + std::to_string(source.port()));
  for (std::size_t i = 0; i < 69; ++i) {
    const int line = i < 3 ? static_cast<int>(i) : static_cast<int>(i) + 1;
    EXPECT_EQ(frames[i].header.sequence, 1000u + static_cast<unsigned>(line));
    EXPECT_EQ(frames[i].has_face, line != 5);
    for (std::size_t shape = 0; shape < kFaceShapes && line != 5; ++shape)
      ASSERT_NEAR(frames[i].value[shape], test::shape_value(line, static_cast<int>(shape)),
                  1e-7);  // half a float's ulp
  }
  EXPECT_EQ(frames[69].header.sequence, 1070u);
  EXPECT_EQ(frames[69].value, frames[0].value);
}

TEST(LiveLinkSender, SendsTheAnglesOfHeadAndEyes) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "face.csv";
  test::write_live_link_csv(path, {.frames = 61});
  const LiveLinkTake take = load_live_link_csv(path);
  boost::asio::io_context io;
  boost::asio::ip::udp::socket receiver(io, {boost::asio::ip::address_v4::loopback(), 0});
  LiveLinkSender sender(io, take, {.port = receiver.local_endpoint().port()});
  sender.start({});
  MarkerFrame frame;
  sender.send_frame(frame, 0);
  std::vector<std::byte> bytes(2048);
  bytes.resize(receiver.receive(boost::asio::buffer(bytes)));
  LiveLinkPacket packet;
  ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
  for (std::size_t i = kFaceShapes; i < kLiveLinkValues; ++i) EXPECT_EQ(packet.value[i], 0.1F);
}

TEST(LiveLinkSender, ARecordingWithoutAShapeOrAnAddressThatIsNoneAreTheUsersToSolve) {
  boost::asio::io_context io;
  LiveLinkTake take{.shapes = {.names = {"jawOpen"}, .frames = {0}, .intensities = {{0.5}}}, .rate_hz = 60};
  EXPECT_THROW(LiveLinkSender(io, take, {}), UserError);
  test::TemporaryFolder folder;
  test::write_live_link_csv(folder.path() / "face.csv");
  take = load_live_link_csv(folder.path() / "face.csv");
  EXPECT_THROW(LiveLinkSender(io, take, {.address = "phone"}), UserError);
  EXPECT_THROW(LiveLinkSender(io, take, {.port = 0}), UserError);
}

}  // namespace
}  // namespace risorius
