// What the subcommands of `risorius serve` share: each protocol adds its own options and makes its server.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>

#include "replay/live/tracker_server.h"

namespace CLI {
class App;
}

namespace risorius {

using MakeTrackerServer = std::function<std::unique_ptr<TrackerServer>(boost::asio::io_context&)>;

/// Adds `serve NAME TAKE` with the options that all protocols have; `make_server` runs when it was chosen, and throws
/// UserError. Returns the subcommand, for the protocol's own options.
CLI::App* add_serve_protocol(CLI::App& serve, const std::string& name, const std::string& description,
                             MakeTrackerServer make_server);

/// `serve natnet`.
void add_serve_natnet(CLI::App& serve);
/// `serve qtm` and `serve vicon`.
void add_serve_qtm(CLI::App& serve);
void add_serve_vicon(CLI::App& serve);

}  // namespace risorius
