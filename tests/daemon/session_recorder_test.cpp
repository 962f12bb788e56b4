#include "daemon/session_recorder.h"

#include <gtest/gtest.h>

#include "replay/session/session_reader.h"
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
  for (std::uint64_t i = 0; i < kOffered; ++i) tap(datagram, RawOrigin{}, static_cast<std::int64_t>(i));
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
  for (int i = 0; i < 10; ++i) tap(datagram, RawOrigin{}, i);
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "");
  SessionReader reader(folder.path() / "s.mcap");
  while (reader.next()) {
  }
  EXPECT_EQ(reader.topics().at("/face/raw").messages, 10u);
  EXPECT_EQ(reader.topics().at("/face/raw").missing, 0u);
}

}  // namespace
}  // namespace risorius
