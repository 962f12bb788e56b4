#include "daemon/session_recorder.h"

#include <gtest/gtest.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "replay/session/session_reader.h"
#include "replay/session/tick_codec.h"
#include "support/test_data.h"

namespace risorius {
namespace {

SessionDescription description() {
  return {.streams = {{"face", "udp", "{}"}}, .config_toml = "", .facts = {}, .monotonic_ns = 0, .utc_ns = 1'000'000};
}

TEST(SessionRecorder, WhatItsQueueHadNoRoomForIsMissingInTheFileToTheMessage) {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "s.mcap";
  SessionRecorder recorder(1, 64 * 1024);
  const std::vector<std::byte> datagram(1000);
  const RawTap tap = recorder.raw_tap(0);
  // Before it starts nothing empties the queue: what does not fit is the end of the topic, which shows in no gap.
  constexpr std::uint64_t kOffered = 500;
  for (std::uint64_t i = 0; i < kOffered; ++i) tap({datagram, RawOrigin{}, static_cast<std::int64_t>(i)});
  EXPECT_EQ(recorder.problem().find("datagrams 500"), std::string::npos);
  recorder.start(path, description());
  recorder.stop();
  EXPECT_NE(recorder.problem().find("session_mib"), std::string::npos) << recorder.problem();
  SessionReader reader(path);
  while (reader.next()) {
  }
  const TopicAccount& raw = reader.topics().at("/face/raw");
  EXPECT_GT(raw.messages, 10u);
  EXPECT_GT(raw.missing, 100u);
  EXPECT_EQ(raw.messages + raw.missing, kOffered);
  ASSERT_EQ(raw.gaps.size(), 1u);
  EXPECT_EQ(raw.gaps[0].missing, raw.missing);
}

TEST(SessionRecorder, HasNoProblemWhereEverythingIsInTheFile) {
  test::TemporaryFolder folder;
  SessionRecorder recorder(1, 64 * 1024);
  recorder.start(folder.path() / "s.mcap", description());
  const RawTap tap = recorder.raw_tap(0);
  const std::vector<std::byte> datagram(1000);
  for (int i = 0; i < 10; ++i) tap({datagram, RawOrigin{}, i});
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "");
  SessionReader reader(folder.path() / "s.mcap");
  while (reader.next()) {
  }
  EXPECT_EQ(reader.topics().at("/face/raw").messages, 10u);
  EXPECT_EQ(reader.topics().at("/face/raw").missing, 0u);
}

TEST(SessionRecorder, OfAFloodOfRefusedDatagramsOnlyABeginIsRecordedAndOfGoodOnesAll) {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "s.mcap";
  SessionRecorder recorder(1, 8 << 20);
  const RawTap tap = recorder.raw_tap(0);
  const std::vector<std::byte> datagram(1000);
  constexpr std::uint64_t kSeconds = 3, kRefused = 1000, kGood = 500;
  for (std::uint64_t second = 0; second < kSeconds; ++second) {
    for (std::uint64_t i = 0; i < kRefused; ++i) {
      const auto now_ns = static_cast<std::int64_t>(1'000'000'000 * (second + 1) + i * 900'000);
      tap({datagram, RawOrigin{}, now_ns, true});
      if (i % (kRefused / kGood) == 0) tap({datagram, RawOrigin{}, now_ns, false});
    }
  }
  recorder.start(path, description());
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "") << "it is meant to be so";
  SessionReader reader(path);
  while (reader.next()) {
  }
  const TopicAccount& raw = reader.topics().at("/face/raw");
  const std::uint64_t refused = raw.messages - kSeconds * kGood;
  EXPECT_LE(refused * datagram.size(), kSeconds * SessionRecorder::kMostRefusedBytes);
  EXPECT_GE(refused * (datagram.size() + 100), kSeconds * SessionRecorder::kMostRefusedBytes) << "but they are used";
  EXPECT_EQ(raw.missing, 0u);
  const std::uint64_t left_out = kSeconds * kRefused - refused;
  EXPECT_EQ(recorder.status().at("refused_not_recorded"), left_out);
  EXPECT_EQ(recorder.status().at("refused_bytes_not_recorded"), left_out * datagram.size());
  EXPECT_EQ(reader.report().at("refused_not_recorded /face/raw"), std::to_string(left_out));
  EXPECT_EQ(reader.report().at("refused_bytes_not_recorded /face/raw"), std::to_string(left_out * datagram.size()));
}

TEST(SessionRecorder, ASetThatFoundTheQueueFullGoesAheadOfTheNextFrameThatFindsRoom) {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "s.mcap";
  SessionRecorder recorder(1, 64 * 1024);
  const MarkerSet set{.id = 4, .names = {"chin", "nose"}, .rate_hz = 120};
  auto item = std::make_unique<AdmittedItem>();
  item->frame.header.set_id = set.id;
  item->frame.count = 2;
  for (int i = 0; i < 3000; ++i) recorder.admitted(*item);  // until nothing more fits
  item->kind = AdmittedItem::Kind::kMarkerSet;
  item->marker_set = &set;
  recorder.admitted(*item);
  EXPECT_GT(recorder.status().at("dropped_ticks"), 1);
  recorder.start(path, description());
  while (recorder.status().at("queued_bytes") > 0) std::this_thread::yield();
  item->kind = AdmittedItem::Kind::kFrame;
  item->frame.header.sequence = 77;
  recorder.admitted(*item);
  recorder.stop();

  SessionReader reader(path);
  SessionTick tick, last_set;
  bool has_set = false, frame_came_after_it = false;
  while (reader.next()) {
    ASSERT_TRUE(decode_tick(reader.message().data, tick));
    if (reader.topic() == SessionTopic::kSets) {
      has_set = true;
      last_set = tick;
    }
    if (reader.topic() == SessionTopic::kTicks && tick.frame.header.sequence == 77) frame_came_after_it = has_set;
  }
  EXPECT_TRUE(frame_came_after_it);
  EXPECT_EQ(last_set.set.names, set.names);
}

}  // namespace
}  // namespace risorius
