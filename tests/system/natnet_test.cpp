// NatNet through the real daemon over real sockets: a take as a tracker streams it, with occlusions, through changes of
// version and a server that dies, at 120 and 1000 Hz.
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <thread>

#include "replay/live/natnet_server.h"
#include "replay/live/take_player.h"
#include "replay/performer/performer.h"
#include "replay/takes/c3d_writer.h"
#include "solve/faces/builtin_face.h"
#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

/// NatNet has metres in float: 1000 times the float nearest to x / 1000 need not be x. Multiples of 2^-14 m are exact
/// in both, so that a take of them arrives bit for bit.
float to_exact_grid(float mm) {
  return static_cast<float>(std::round(static_cast<double>(mm) / 1000 * 16384) * 1000 / 16384);
}

/// The performer's take on that grid, as a file. Returns the number of frames.
std::uint64_t write_take(const std::filesystem::path& path, double rate_hz, double seconds) {
  PerformerTake take(builtin_rig(), {.rate_hz = rate_hz, .seconds = seconds});
  C3dWriter writer(path, take.info().markers, "test");
  MarkerFrame frame;
  std::uint64_t count = 0, missing = 0;
  for (; take.next(frame); ++count) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      Position& p = frame.position_mm[i];
      p = {to_exact_grid(p.x), to_exact_grid(p.y), to_exact_grid(p.z)};
      missing += frame.state[i] == MarkerState::kMeasured ? 0 : 1;
    }
    writer.write(frame);
  }
  writer.finish();
  EXPECT_GT(missing, count / 10);  // the take has occlusions
  return count;
}

std::string source_of(const std::string& endpoint) {
  // All frames fit: how busy the machine is must not decide what is admitted.
  return fmt::format(
      "[queues]\nadmission = 8192\npublish = 8192\nrecord = 8192\n[[source]]\nname = \"face\"\nlisten = \"{}\"\n"
      "natnet_local_address = \"127.0.0.11\"\n",
      endpoint);
}

/// Changes the stream's version a third and two thirds on its way.
class ChangingServer : public TrackerServer {
 public:
  ChangingServer(NatnetServer& server, std::uint64_t frames) : server_(server), frames_(frames) {}
  void start(const MarkerSet& set) override { server_.start(set); }
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override {
    if (frame.header.sequence == frames_ / 3) server_.change_version({4, 1});
    if (frame.header.sequence == 2 * frames_ / 3) server_.change_version({4, 0});
    server_.send_frame(frame, exposure_ns);
  }
  void stop() noexcept override { server_.stop(); }
  std::size_t streaming_clients() const noexcept override { return server_.streaming_clients(); }
  std::string endpoint() const override { return server_.endpoint(); }
  const TrackerServerStatistics& statistics() const noexcept override { return server_.statistics(); }

 private:
  NatnetServer& server_;
  std::uint64_t frames_;
};

class NatnetStream : public testing::TestWithParam<double> {};

TEST_P(NatnetStream, EqualsOfflineThroughTwoChangesOfVersion) {
  TemporaryFolder folder;
  const auto path = folder.path() / "take.c3d";
  const std::uint64_t frames = write_take(path, GetParam(), 1.5);
  const auto offline = folder.path() / "offline";
  const auto made = run(
      {program("risorius").string(), "dataset", path.string(), "--rig", "builtin", "--causal", "-o", offline.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;

  boost::asio::io_context io;
  NatnetServer natnet(io, {.address = "127.0.0.7", .command_port = 0, .version = {3, 0}});
  ChangingServer server(natnet, frames);
  const auto take = open_take(path);
  bool ended = false;
  TakePlayer player(io, *take, server, {.wait_for_client = true}, [&] { ended = true; });
  player.start();
  RunningDaemon daemon(folder.path(), source_of(natnet.endpoint()));
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  while (!ended) ASSERT_GT(io.run_one_for(std::chrono::seconds(30)), 0u);
  ASSERT_TRUE(all_solved(daemon, {{"face", frames}}));
  const auto stream = daemon.status().at("streams").at("face");
  expect_nothing_lost(stream, frames);
  EXPECT_EQ(stream.at("datagrams").at("refused"), 0);
  EXPECT_EQ(stream.at("frames").at("sessions"), 1);
  server.stop();
  const auto ended_daemon = daemon.end();
  ASSERT_EQ(ended_daemon.exit_code, 0) << ended_daemon.output;
  expect_equal_takes(daemon.dataset() / "face-001", offline / "take");
}

INSTANTIATE_TEST_SUITE_P(Rates, NatnetStream, testing::Values(120.0, 1000.0),
                         [](const auto& rate) { return fmt::format("At{:.0f}Hz", rate.param); });

TEST(Natnet, AServerThatDiesAndComesBackIsTwoWholeTakes) {
  TemporaryFolder folder;
  const auto path = folder.path() / "take.c3d";
  const std::uint64_t frames = write_take(path, 120, 1);
  const std::string tool = program("risorius").string();
  const auto offline = folder.path() / "offline";
  const auto made = run({tool, "dataset", path.string(), "--rig", "builtin", "--causal", "-o", offline.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;

  // A port of our own at an address of our own: the second server must be where the first one was.
  boost::asio::io_context io;
  const std::string endpoint = NatnetServer(io, {.address = "127.0.0.12", .command_port = 0}).endpoint();
  const std::string listen = endpoint.substr(std::string("natnet://").size());
  RunningDaemon daemon(folder.path(), source_of(endpoint));
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  {
    Process first({tool, "serve", "natnet", path.string(), "--listen", listen, "--wait", "--loop"});
    ASSERT_TRUE(all_solved(daemon, {{"face", 40}}));
    first.send_signal(SIGKILL);
    first.finish();
  }
  const auto seen = [&](const char* what) {
    return daemon.status().at("streams").at("face").at("frames").at(what).get<std::uint64_t>();
  };
  Process second({tool, "serve", "natnet", path.string(), "--listen", listen, "--wait", "--natnet-version", "3.1"});
  const auto served = second.finish();
  ASSERT_EQ(served.exit_code, 0) << served.output;
  EXPECT_NE(served.output.find("played 120 frames; sent 120, not sent 0, to 1 clients"), std::string::npos)
      << served.output;
  EXPECT_EQ(seen("sessions"), 2u);
  EXPECT_EQ(daemon.status().at("streams").at("face").at("link").at("reconnects"), 1);
  const auto ended = daemon.end();
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(frames, 120u);
  EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / "face-001"));
  expect_equal_takes(daemon.dataset() / "face-002", offline / "take");
}

}  // namespace
}  // namespace risorius::test
