// risorius serve: a take as a tracker's server, so that clients can be tried without hardware.
#include "replay/commands/command_serve.h"

#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <fmt/format.h>
#include <utility>

#include "replay/commands/commands.h"
#include "replay/commands/take_arguments.h"
#include "replay/live/take_player.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

constexpr auto kProgressPeriod = std::chrono::milliseconds(100);
constexpr double kFrameCapHz = 4000;  // with --speed max: a client must not drown

struct ServeArguments {
  std::string take;
  bool wait = false;
  PlayArguments play;
  TakeArguments take_arguments;
};

void print_summary(const TrackerServer& server, const TakePlayer& player) {
  const auto& served = server.statistics();
  const auto& paced = player.pace();
  fmt::print(stderr,
             "played {} frames; sent {}, not sent {}, to {} clients; requests {}, refused {}; late by more than 1 ms: "
             "{}, latest {:.2f} ms\n",
             served.frames, served.frames_sent, served.frames_not_sent, served.clients, served.requests,
             served.refused_requests, paced.late_frames, static_cast<double>(paced.max_lateness_ns) * 1e-6);
}

// Redraws the progress line from time to time while the io_context runs.
class ProgressTimer {
 public:
  ProgressTimer(boost::asio::io_context& io, const TakePlayer& player, std::uint64_t of)
      : timer_(io), player_(player), of_(of), line_("serve", "frames") {
    arm();
  }
  void finish() { line_.finish(player_.frames_played()); }

 private:
  void arm() {
    timer_.expires_after(kProgressPeriod);
    timer_.async_wait([this](const boost::system::error_code& error) {
      if (error) return;
      line_.show(player_.frames_played(), of_);
      arm();
    });
  }
  boost::asio::steady_timer timer_;
  const TakePlayer& player_;
  std::uint64_t of_;
  ProgressLine line_;
};

void serve(const ServeArguments& arguments, const MakeTrackerServer& make_server) {
  const auto take = open_take_or_builtin(arguments.take, arguments.take_arguments.options());
  print_warnings(*take);
  boost::asio::io_context io(1);
  const auto server = make_server(io);
  play_to_server(io, *take, *server, arguments.play, arguments.wait,
                 fmt::format("serving {} on {}", arguments.take, server->endpoint()));
}

}  // namespace

void PlayArguments::add_to(CLI::App& command) {
  pace.add_to(command);
  command.add_flag("--quiet", quiet, "no progress line and no summary");
}

void play_to_server(boost::asio::io_context& io, TakeReader& take, TrackerServer& server,
                    const PlayArguments& arguments, bool wait_for_client, const std::string& announcement) {
  const TakePlayerOptions options{.pace = {.speed = arguments.pace.speed_factor(), .frame_cap_hz = kFrameCapHz},
                                  .loop = arguments.pace.loop,
                                  .wait_for_client = wait_for_client};
  TakePlayer player(io, take, server, options, [&io] { io.stop(); });
  boost::asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&io](const boost::system::error_code& error, int) {
    if (!error) io.stop();
  });
  player.start();
  fmt::print("{}\n", announcement);
  std::fflush(stdout);
  {
    std::unique_ptr<ProgressTimer> progress;
    if (!arguments.quiet) {
      progress = std::make_unique<ProgressTimer>(io, player, options.loop ? 0 : take.info().frame_count.value_or(0));
    }
    io.run();
    if (progress) progress->finish();
  }
  player.stop();
  server.stop();
  if (!arguments.quiet) print_summary(server, player);
}

CLI::App* add_serve_protocol(CLI::App& serve_command, const std::string& name, const std::string& description,
                             MakeTrackerServer make_server) {
  CLI::App* command = serve_command.add_subcommand(name, description);
  auto arguments = std::make_shared<ServeArguments>();
  command->add_option("take", arguments->take, "take (.c3d, .csv), or \"builtin\", or \"builtin:SECONDS\"")->required();
  arguments->play.add_to(*command);
  command->add_flag("--wait", arguments->wait, "begin the take when the first client wants frames");
  arguments->take_arguments.add_to(*command);
  command->callback([arguments, make_server = std::move(make_server)] { serve(*arguments, make_server); });
  return command;
}

void add_serve_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("serve", "play a take as a tracker: OptiTrack, Qualisys, Vicon, or Live Link Face");
  command->require_subcommand(1);
  add_serve_livelink(*command);
  add_serve_natnet(*command);
  add_serve_qtm(*command);
  add_serve_vicon(*command);
}

}  // namespace risorius
