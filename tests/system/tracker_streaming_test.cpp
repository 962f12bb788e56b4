// Takes played by our QTM and Vicon servers into the real daemon over real sockets: names, occlusions and false tracks,
// TCP and UDP, older versions, servers that start over. What is recorded equals the offline causal run bit for bit.
#include <chrono>
#include <fstream>
#include <gtest/gtest.h>
#include <map>

#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

/// A performed take with occlusions and false tracks, and its offline causal dataset.
struct Performed {
  Performed(const std::filesystem::path& folder, const std::string& name, double rate_hz, double seconds, int seed)
      : take((folder / (name + ".c3d")).string()), offline(folder / ("offline-" + name) / name) {
    const std::string tool = program("risorius").string();
    const auto made =
        run({tool, "perform", "--script", "mixed", "--seconds", std::to_string(seconds), "--rate",
             std::to_string(rate_hz), "--occlude", "--outliers", "--seed", std::to_string(seed), "-o", take});
    EXPECT_EQ(made.exit_code, 0) << made.output;
    const auto solved =
        run({tool, "dataset", take, "--rig", "builtin", "--causal", "-o", offline.parent_path().string()});
    EXPECT_EQ(solved.exit_code, 0) << solved.output;
    frames = static_cast<std::uint64_t>(rate_hz * seconds + 0.5);
  }
  std::string take;
  std::filesystem::path offline;
  std::uint64_t frames = 0;
};

/// A `risorius serve` process on a port of the system's choice, or on a given one.
struct Serving {
  Serving(const std::string& kind, const std::string& take, std::vector<std::string> more = {},
          const std::string& listen = "127.0.0.1:0") {
    std::vector<std::string> command{program("risorius").string(), "serve", kind, take, "--wait", "--listen", listen};
    command.insert(command.end(), more.begin(), more.end());
    process = std::make_unique<Process>(command);
    EXPECT_TRUE(process->wait_for_output(" on " + kind + "://", 30) && process->wait_for_output("\n", 5))
        << process->output();
    const std::string& output = process->output();
    const auto begin = output.find(" on " + kind + "://") + 4;
    url = output.substr(begin, output.find('\n', begin) - begin);
  }
  std::string address() const { return url.substr(url.find("//") + 2); }
  std::unique_ptr<Process> process;
  std::string url;
};

std::string source(const std::string& name, const std::string& url, const std::string& more = "") {
  return "[[source]]\nname = \"" + name + "\"\nlisten = \"" + url + "\"\n" + more + "\n";
}

// All frames fit: how busy the machine is must not decide what is admitted.
const char* const kQueues = "[queues]\nadmission = 16384\npublish = 16384\nrecord = 16384\n";

nlohmann::json wait_for(const RunningDaemon& daemon, const std::map<std::string, std::uint64_t>& frames) {
  EXPECT_TRUE(all_solved(daemon, frames)) << "not all frames came";
  return daemon.status().at("streams");
}

void expect_equal_over_all_transports(double rate_hz, double seconds) {
  TemporaryFolder folder;
  const Performed performed(folder.path(), "take", rate_hz, seconds, 5);
  Serving vicon("vicon", performed.take), tcp("qtm", performed.take), udp("qtm", performed.take);
  RunningDaemon daemon(
      folder.path(),
      source("vicon", vicon.url) + source("tcp", tcp.url) + source("udp", udp.url, "qtm_frames = \"udp\""), kQueues);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  for (Serving* serving : {&vicon, &tcp, &udp}) EXPECT_EQ(serving->process->finish().exit_code, 0);
  const std::uint64_t frames = performed.frames;
  const auto streams = wait_for(daemon, {{"vicon", frames}, {"tcp", frames}, {"udp", frames}});
  for (const char* name : {"vicon", "tcp", "udp"}) {
    SCOPED_TRACE(name);
    expect_nothing_lost(streams.at(name), frames);
    EXPECT_EQ(streams.at(name).at("frames").at("sessions"), 1);
  }
  const auto ended = daemon.end();
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  for (const char* name : {"vicon", "tcp", "udp"})
    expect_equal_takes(daemon.dataset() / (std::string(name) + "-001"), performed.offline);
}

TEST(TrackerStreaming, EqualsOfflineOverAllTransportsAt120Hz) { expect_equal_over_all_transports(120, 2); }

TEST(TrackerStreaming, EqualsOfflineOverAllTransportsAt1000Hz) { expect_equal_over_all_transports(1000, 1.5); }

TEST(TrackerStreaming, TakesServersThatStartOverAndSpeakAnOlderVersion) {
  TemporaryFolder folder;
  const Performed first(folder.path(), "first", 120, 0.75, 6), second(folder.path(), "second", 120, 0.75, 7);
  auto vicon = std::make_unique<Serving>("vicon", first.take);
  auto qtm = std::make_unique<Serving>("qtm", first.take, std::vector<std::string>{"--newest-version", "13"});
  RunningDaemon daemon(folder.path(), source("vicon", vicon->url) + source("qtm", qtm->url), kQueues);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const std::string vicon_address = vicon->address(), qtm_address = qtm->address();
  EXPECT_EQ(vicon->process->finish().exit_code, 0);
  EXPECT_EQ(qtm->process->finish().exit_code, 0);
  wait_for(daemon, {{"vicon", first.frames}, {"qtm", first.frames}});
  // The same addresses, another take, with Y up; and QTM without any version that the client knows.
  vicon = std::make_unique<Serving>("vicon", second.take, std::vector<std::string>{"--y-up"}, vicon_address);
  qtm = std::make_unique<Serving>("qtm", second.take, std::vector<std::string>{"--newest-version", "1"}, qtm_address);
  EXPECT_EQ(vicon->process->finish().exit_code, 0);
  EXPECT_EQ(qtm->process->finish().exit_code, 0);
  const std::uint64_t frames = first.frames + second.frames;
  const auto streams = wait_for(daemon, {{"vicon", frames}, {"qtm", frames}});
  for (const char* name : {"vicon", "qtm"}) {
    SCOPED_TRACE(name);
    expect_nothing_lost(streams.at(name), frames);
    EXPECT_EQ(streams.at(name).at("frames").at("sessions"), 2);
    EXPECT_EQ(streams.at(name).at("link").at("reconnects"), 1);
  }
  ASSERT_EQ(daemon.end().exit_code, 0);
  for (const std::string name : {"vicon", "qtm"}) {
    expect_equal_takes(daemon.dataset() / (name + "-001"), first.offline);
    expect_equal_takes(daemon.dataset() / (name + "-002"), second.offline);
  }
}

/// What came from a tracker, recorded as a session, and replayed to another daemon, which takes the native protocol.
TEST(TrackerStreaming, ASessionIsReplayedAsItsFrames) {
  TemporaryFolder folder, second;
  const Performed performed(folder.path(), "take", 120, 1, 8);
  Serving vicon("vicon", performed.take), qtm("qtm", performed.take), natnet("natnet", performed.take);
  const auto file = folder.path() / "session.mcap";
  RunningDaemon daemon(folder.path(),
                       source("vicon", vicon.url) + source("qtm", qtm.url) + source("natnet", natnet.url),
                       "session = \"" + file.string() + "\"\n" + kQueues);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  for (Serving* serving : {&vicon, &qtm, &natnet}) EXPECT_EQ(serving->process->finish().exit_code, 0);
  const std::uint64_t frames = performed.frames;
  wait_for(daemon, {{"vicon", frames}, {"qtm", frames}, {"natnet", frames}});
  ASSERT_EQ(daemon.end().exit_code, 0);

  RunningDaemon again(second.path(),
                      source("vicon", "udp://127.0.0.1:0") + source("qtm", "zmq+tcp://127.0.0.1:0") +
                          source("natnet", "udp://127.0.0.1:0"),
                      kQueues);
  ASSERT_TRUE(again.up()) << again.process().output();
  for (const char* name : {"vicon", "qtm", "natnet"}) {
    SCOPED_TRACE(name);
    const auto sent = run({program("risorius").string(), "replay", file.string(), "--stream", name, "--to",
                           again.input(name), "--speed", "2"});
    EXPECT_EQ(sent.exit_code, 0) << sent.output;
    EXPECT_NE(sent.output.find("its frames are sent"), std::string::npos) << sent.output;
    EXPECT_NE(sent.output.find("sent " + std::to_string(frames) + " frames; not sent 0"), std::string::npos)
        << sent.output;
  }
  const auto streams = wait_for(again, {{"vicon", frames}, {"qtm", frames}, {"natnet", frames}});
  for (const char* name : {"vicon", "qtm", "natnet"}) expect_nothing_lost(streams.at(name), frames);
  ASSERT_EQ(again.end().exit_code, 0);
  for (const std::string name : {"vicon", "qtm", "natnet"}) {
    SCOPED_TRACE(name);
    expect_equal_takes(again.dataset() / (name + "-001"), daemon.dataset() / (name + "-001"));
  }
}

}  // namespace
}  // namespace risorius::test
