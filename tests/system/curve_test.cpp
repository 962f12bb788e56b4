// CURVE keys from end to end, as users set them up: `risorius keys`, the daemon's configuration, `risorius replay`.
#include <gtest/gtest.h>

#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

TEST(Curve, OnlySendersWithAListedKeyReachAnEncryptedSource) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  std::filesystem::create_directory(path("senders"));
  for (const char* name : {"daemon", "senders/anna", "stranger"}) {
    const auto made = run({tool, "keys", path(name)});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  EXPECT_NE(run({tool, "keys", path("daemon")}).exit_code, 0) << "a key was overwritten";

  RunningDaemon daemon(folder.path(),
                       "[[source]]\nname = \"face\"\nlisten = \"zmq+tcp://127.0.0.1:0\"\ncurve_key = \"" +
                           path("daemon.key_secret") + "\"\ncurve_clients = \"" + path("senders") + "\"\n");
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const auto replay_with = [&](const char* key) {
    return run({tool, "replay", "builtin:1", "--to", daemon.input("face"), "--speed", "2", "--curve-server",
                path("daemon.key"), "--curve-key", path(key)});
  };
  const auto refused = replay_with("stranger.key_secret");
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("refuses our key"), std::string::npos) << refused.output;
  const auto& face = [&] { return daemon.status().at("streams").at("face"); };
  EXPECT_GT(face().at("link").at("refused_connections"), 0);
  EXPECT_EQ(face().at("datagrams").at("received"), 0);

  const auto sent = replay_with("senders/anna.key_secret");
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  ASSERT_TRUE(all_solved(daemon, {{"face", 120}}));
  expect_nothing_lost(face(), 120);
  const auto ended = daemon.end();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_NE(ended.output.find("refused_connections"), std::string::npos)
      << "the terminal says so, too: " << ended.output;
}

}  // namespace
}  // namespace risorius::test
