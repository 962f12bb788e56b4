// What the subcommands of `risorius serve` share: each protocol adds its own options and makes its server.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>

#include "replay/commands/pace_arguments.h"
#include "replay/live/tracker_server.h"
#include "replay/takes/take.h"

namespace CLI {
class App;
}

namespace risorius {

using MakeTrackerServer = std::function<std::unique_ptr<TrackerServer>(boost::asio::io_context&)>;

/// Adds `serve NAME TAKE` with the options that all protocols have; `make_server` runs when it was chosen, and throws
/// UserError. Returns the subcommand, for the protocol's own options.
CLI::App* add_serve_protocol(CLI::App& serve, const std::string& name, const std::string& description,
                             MakeTrackerServer make_server);

/// How anything is played.
struct PlayArguments {
  PaceArguments pace;
  bool quiet = false;

  void add_to(CLI::App& command);
};

/// Plays the take through the server until its end, SIGINT or SIGTERM; prints `announcement` once it has begun.
void play_to_server(boost::asio::io_context& io, TakeReader& take, TrackerServer& server,
                    const PlayArguments& arguments, bool wait_for_client, const std::string& announcement);

/// `serve livelink`.
void add_serve_livelink(CLI::App& serve);
/// `serve natnet`.
void add_serve_natnet(CLI::App& serve);
/// `serve qtm` and `serve vicon`.
void add_serve_qtm(CLI::App& serve);
void add_serve_vicon(CLI::App& serve);

}  // namespace risorius
