// Live Link Face through the real daemon over real sockets: what is recorded equals the offline mapping of the same
// recording bit for bit, once its numbers have been rounded to the floats that the packets hold.
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <thread>

#include "replay/live/daemon_client.h"
#include "replay/takes/arkit_aus.h"
#include "replay/takes/au_csv.h"
#include "replay/takes/live_link_csv.h"
#include "solve/faces/builtin_face.h"
#include "support/live_link_csv_file.h"
#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

constexpr const char* kSource =
    "[queues]\nadmission = 8192\npublish = 8192\nrecord = 8192\n[[source]]\nname = \"phone\"\n"
    "listen = \"livelink://127.0.0.1:0\"\n";

std::string port_of(const std::string& endpoint) { return endpoint.substr(endpoint.rfind(':') + 1); }

std::vector<std::string> sending(const RunningDaemon& daemon, const std::filesystem::path& csv,
                                 std::vector<std::string> more = {}) {
  std::vector<std::string> command{program("risorius").string(),
                                   "serve",
                                   "livelink",
                                   csv.string(),
                                   "--quiet",
                                   "--to",
                                   "127.0.0.1:" + port_of(daemon.input("phone"))};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

/// au.csv of the recording, mapped offline: the table, then the rig's columns by name.
std::string offline_aus(const std::filesystem::path& csv, const std::filesystem::path& out, std::uint64_t first_frame) {
  LiveLinkTake take = load_live_link_csv(csv);
  for (auto& row : take.shapes.intensities) {
    for (double& value : row) value = static_cast<double>(static_cast<float>(value));
  }
  const AuSeries aus = aus_of_shapes(take.shapes, shipped_arkit_table());
  const Rig rig = builtin_rig();
  AuCsvWriter writer(out, rig.au_names());
  std::uint64_t next = 0;
  for (std::size_t f = 0; f < aus.frames.size(); ++f) {
    for (; next <= aus.frames[f]; ++next) {
      AuFrame frame;
      frame.header.sequence = first_frame + next;
      frame.count = static_cast<std::uint32_t>(rig.au_count());
      for (std::size_t k = 0; k < rig.au_count() && next == aus.frames[f]; ++k) {
        const auto columns = columns_for(aus.names, rig.aus[k].name);
        double sum = 0;
        for (const std::size_t column : columns) sum += aus.intensities[f][column];
        if (columns.empty() || std::isnan(sum)) continue;
        frame.state[k] = AuState::kObserved;
        frame.intensity[k] = std::min(sum / static_cast<double>(columns.size()), rig.aus[k].upper_bound);
      }
      writer.write(frame);
    }
  }
  writer.finish();
  return bytes_of_file(out);
}

nlohmann::json take_json(const RunningDaemon& daemon, const std::string& take) {
  return nlohmann::json::parse(bytes_of_file(daemon.dataset() / take / "take.json"));
}

void expect_ledgers_balance(const nlohmann::json& stream) {
  for (const char* ledger : {"datagrams", "reorder", "admission"}) expect_balanced(stream.at(ledger), ledger);
  expect_balanced(stream.at("frames").at("assembled"), "assembled");
}

TEST(LiveLinkStreaming, WhatIsRecordedEqualsTheOfflineMappingAcrossMidnight) {
  TemporaryFolder folder;
  const auto csv = folder.path() / "face.csv";
  write_live_link_csv(csv, {.frames = 150, .lost = {40, 41, 42}, .without_face = {90, 91}});
  // 100 frames before midnight.
  for (const std::string first : {"0", "5183900"}) {
    const auto here = folder.path() / first;
    std::filesystem::create_directory(here);
    RunningDaemon daemon(here, kSource);
    ASSERT_TRUE(daemon.up());
    const auto sent = run(sending(daemon, csv, {"--first-frame", first, "--speed", "4"}));
    ASSERT_EQ(sent.exit_code, 0) << sent.output;
    ASSERT_TRUE(all_solved(daemon, {{"phone", 147}}));
    const auto stream = daemon.status().at("streams").at("phone");
    EXPECT_EQ(stream.at("frames").at("lost"), 3);
    EXPECT_EQ(stream.at("frames").at("sessions"), 1);
    EXPECT_EQ(stream.at("solver").at("mapped"), 145);
    EXPECT_EQ(stream.at("solver").at("no_face"), 2);
    EXPECT_EQ(stream.at("solved"), 145);
    EXPECT_EQ(stream.at("tracker").at("frames_without_face"), 2);
    EXPECT_GT(stream.at("continuations"), 0);
    expect_ledgers_balance(stream);
    const auto ended = daemon.end();
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    const auto take = daemon.dataset() / "phone-001";
    EXPECT_EQ(bytes_of_file(take / "au.csv"), offline_aus(csv, here / "offline.csv", std::stoull(first)));
    EXPECT_FALSE(std::filesystem::exists(take / "cleaned.c3d"));
    const auto json = take_json(daemon, "phone-001");
    EXPECT_EQ(json.at("level"), "au");
    EXPECT_EQ(json.at("rate_hz"), 60);
    EXPECT_EQ(json.at("frames"), 150);
    EXPECT_EQ(json.at("lost_frames"), 3);
    EXPECT_EQ(json.at("solved_frames"), 145);
    EXPECT_EQ(json.at("shapes").at("arkit_table").at("version"), 1);
    EXPECT_NE(bytes_of_file(daemon.dataset() / "README.md").find("Takes of phone have no markers"), std::string::npos);
  }
}

TEST(LiveLinkStreaming, ARealRecordingEqualsItsOfflineMapping) {
  RISORIUS_NEEDS_DATA(csv, "arkit/alex_rom_3.csv");
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kSource);
  ASSERT_TRUE(daemon.up());
  const auto sent = run(sending(daemon, csv, {"--speed", "60"}));
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  const std::uint64_t frames = load_live_link_csv(csv).shapes.frames.size();
  ASSERT_TRUE(all_solved(daemon, {{"phone", frames}}));
  EXPECT_EQ(daemon.end().exit_code, 0);
  EXPECT_TRUE(bytes_of_file(daemon.dataset() / "phone-001" / "au.csv") ==
              offline_aus(csv, folder.path() / "offline.csv", 0));
}

TEST(LiveLinkStreaming, ASenderThatStartsOverBeginsATakeAndAnotherDeviceIsCounted) {
  TemporaryFolder folder;
  const auto csv = folder.path() / "face.csv";
  write_live_link_csv(csv, {.frames = 90});
  RunningDaemon daemon(folder.path(), std::string(kSource) + "livelink_device = \"Anna\"\n");
  ASSERT_TRUE(daemon.up());
  const std::vector<std::string> anna{"--device", "Anna", "--speed", "4"};
  ASSERT_EQ(run(sending(daemon, csv, anna)).exit_code, 0);
  ASSERT_EQ(run(sending(daemon, csv, {"--device", "Ben", "--speed", "4"})).exit_code, 0);
  auto one_byte = anna;
  one_byte.push_back("--one-byte-version");
  ASSERT_EQ(run(sending(daemon, csv, one_byte)).exit_code, 0);
  ASSERT_TRUE(all_solved(daemon, {{"phone", 90 + 89}}));  // the first packet after a leap waits for a second
  const auto stream = daemon.status().at("streams").at("phone");
  EXPECT_EQ(stream.at("datagrams").at("errors").at("other_device"), 90);
  EXPECT_EQ(stream.at("datagrams").at("errors").at("leap"), 1);
  EXPECT_EQ(stream.at("frames").at("sessions"), 2);
  EXPECT_EQ(stream.at("frames").at("lost"), 0);
  expect_ledgers_balance(stream);
  EXPECT_EQ(daemon.end().exit_code, 0);
  EXPECT_EQ(take_json(daemon, "phone-001").at("frames"), 90);
  EXPECT_EQ(take_json(daemon, "phone-002").at("frames"), 89);
}

TEST(LiveLinkStreaming, ANeutralIsTakenOffAndKeptWithTheTakeThatItHoldsFor) {
  TemporaryFolder folder;
  const auto csv = folder.path() / "face.csv";
  write_live_link_csv(csv, {.frames = 240});
  RunningDaemon daemon(folder.path(), kSource);
  ASSERT_TRUE(daemon.up());
  EXPECT_THROW(ask_daemon(daemon.control(), {{"command", "capture_neutral"}}, std::chrono::seconds(10)).at("seconds"),
               std::exception);  // no frames yet
  Process sender(sending(daemon, csv, {"--speed", "2"}));
  ASSERT_TRUE(all_solved(daemon, {{"phone", 30}}));
  const auto answer =
      ask_daemon(daemon.control(), {{"command", "capture_neutral"}, {"seconds", 0.5}}, std::chrono::seconds(10));
  EXPECT_TRUE(answer.at("ok")) << answer.dump();
  EXPECT_EQ(sender.finish().exit_code, 0);
  ASSERT_TRUE(all_solved(daemon, {{"phone", 240}}));
  EXPECT_EQ(daemon.status().at("streams").at("phone").at("neutral_captures"), 1);
  EXPECT_EQ(daemon.end().exit_code, 0);
  EXPECT_TRUE(take_json(daemon, "phone-001").at("shapes").at("neutral").empty());
  const auto neutral = take_json(daemon, "phone-002").at("shapes").at("neutral");
  EXPECT_GT(neutral.at("jawOpen").get<double>(), 0.1);  // the mean of the made-up sines is about 0.5
  EXPECT_LT(neutral.at("jawOpen").get<double>(), 0.9);
}

}  // namespace
}  // namespace risorius::test
