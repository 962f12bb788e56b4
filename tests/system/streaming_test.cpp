// Takes over real sockets through the real daemon: what is recorded equals the offline causal run bit for bit, ledgers
// balance and nothing is lost.
#include <chrono>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

const char* const kFace = "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n";

TEST(Streaming, BuiltinOverUdpEqualsOffline) {
  TemporaryFolder folder;
  const auto offline = folder.path() / "offline";
  const auto made = run(
      {program("risorius").string(), "dataset", "builtin:4", "--rig", "builtin", "--causal", "-o", offline.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const auto sent =
      run({program("risorius").string(), "replay", "builtin:4", "--to", daemon.input("face"), "--speed", "4"});
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  constexpr std::uint64_t kFrames = 480;  // 4 s at the performer's 120 Hz
  ASSERT_TRUE(all_solved(daemon, {{"face", kFrames}}));
  expect_nothing_lost(daemon.status().at("streams").at("face"), kFrames);
  const auto ended = daemon.end();
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  expect_equal_takes(daemon.dataset() / "face-001", offline / "builtin");
  const auto checked =
      run({"sh", "-c", "cd '" + daemon.dataset().string() + "' && sha256sum -c --quiet manifest-sha256.txt"});
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
}

/// Of a stream of 120 Hz that goes on, when `enough` or 30 s have passed.
template <class Enough>
nlohmann::json forecast_of(const RunningDaemon& daemon, Enough enough) {
  nlohmann::json face;
  const auto begin = std::chrono::steady_clock::now();
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    face = daemon.status().at("streams").at("face");
  } while (!enough(face) && std::chrono::steady_clock::now() - begin < std::chrono::seconds(30));
  return face.at("forecast");
}

TEST(Streaming, FramesOfARhythmAreForeseenAndTheDaemonEndsWhileItWaitsForOne) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, "", Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const Process sender(
      {program("risorius").string(), "replay", "--quiet", "builtin:120", "--to", daemon.input("face")});
  // On a machine that is busy with other things few frames come when they should.
  const auto foreseen = [](const nlohmann::json& face) { return face.at("forecast").at("foreseen") > 0; };
  EXPECT_GT(forecast_of(daemon, foreseen).at("foreseen"), 0);
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Streaming, NoFrameIsForeseenWhereNobodyIsToBeAwakeForIt) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, "[latency]\nawake_share = 0\n", Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const Process sender(
      {program("risorius").string(), "replay", "--quiet", "builtin:120", "--to", daemon.input("face")});
  const auto solved = [](const nlohmann::json& face) { return face.at("processed") > 150; };
  const auto forecast = forecast_of(daemon, solved);
  EXPECT_EQ(forecast.at("foreseen"), 0);
  EXPECT_EQ(forecast.at("missed"), 0);
}

TEST(Streaming, TwoRealTakesAtOnceOverUdpAndZmqEqualOffline) {
  RISORIUS_NEEDS_DATA(animface, "animface");
  RISORIUS_NEEDS_DATA(ict_archive, "ict_facekit.tar.xz");
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto rig = (folder.path() / "rig.json").string();
  ASSERT_EQ(run({"tar", "xJf", ict_archive.string(), "-C", folder.path().string()}).exit_code, 0);
  const auto fitted = run({tool, "rig", "fit", "--face", (folder.path() / "ict_facekit").string(), "--neutral",
                           (animface / "jaw.c3d").string() + ":20-90", "--landmarks", "animface41", "-o", rig});
  ASSERT_EQ(fitted.exit_code, 0) << fitted.output;
  const auto jaw = (animface / "jaw_defects.c3d").string(), eyebrows = (animface / "eyebrows_defects.c3d").string();
  const auto offline = folder.path() / "offline";
  const auto made = run({tool, "dataset", jaw, eyebrows, "--rig", rig, "--causal", "-o", offline.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;

  RunningDaemon daemon(folder.path(),
                       // All frames fit: how busy the machine is must not decide what is admitted.
                       "[queues]\nadmission = 4096\npublish = 4096\n[[source]]\nname = \"jaw\"\nlisten = "
                       "\"udp://127.0.0.1:0\"\nrig = \"" +
                           rig + "\"\n[[source]]\nname = \"eyebrows\"\nlisten = \"zmq+tcp://127.0.0.1:0\"\nrig = \"" +
                           rig + "\"\n");
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  Process first({tool, "replay", jaw, "--to", daemon.input("jaw"), "--speed", "10"});
  Process second({tool, "replay", eyebrows, "--to", daemon.input("eyebrows"), "--speed", "10"});
  const auto first_ended = first.finish(), second_ended = second.finish();
  ASSERT_EQ(first_ended.exit_code, 0) << first_ended.output;
  ASSERT_EQ(second_ended.exit_code, 0) << second_ended.output;
  // 1590 and 902 frames: the data folder's README.
  ASSERT_TRUE(all_solved(daemon, {{"jaw", 1590}, {"eyebrows", 902}}));
  const auto streams = daemon.status().at("streams");
  expect_nothing_lost(streams.at("jaw"), 1590);
  expect_nothing_lost(streams.at("eyebrows"), 902);
  ASSERT_EQ(daemon.end().exit_code, 0);
  expect_equal_takes(daemon.dataset() / "jaw-001", offline / "jaw_defects");
  expect_equal_takes(daemon.dataset() / "eyebrows-001", offline / "eyebrows_defects");
}

}  // namespace
}  // namespace risorius::test
