// risorius serve natnet: a take as OptiTrack Motive would stream it.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/command_serve.h"
#include "replay/live/natnet_server.h"

namespace risorius {
namespace {

struct NatnetArguments {
  NatnetServerOptions server;
  std::string listen = "127.0.0.1:1510", version = "4.1";
};

/// "ADDRESS" or "ADDRESS:PORT".
void read_listen(const std::string& listen, NatnetServerOptions& options) {
  const auto colon = listen.rfind(':');
  options.address = listen.substr(0, colon);
  if (colon == std::string::npos) return;
  if (!CLI::detail::lexical_cast(listen.substr(colon + 1), options.command_port)) {
    throw UserError("--listen", "\"" + listen + "\" has no port from 0 to 65535", "such as 127.0.0.1:1510");
  }
}

}  // namespace

void add_serve_natnet(CLI::App& serve) {
  auto arguments = std::make_shared<NatnetArguments>();
  CLI::App* command =
      add_serve_protocol(serve, "natnet", "as OptiTrack Motive (NatNet)", [arguments](boost::asio::io_context& io) {
        read_listen(arguments->listen, arguments->server);
        arguments->server.version = parse_natnet_version(arguments->version);
        auto server = std::make_unique<NatnetServer>(io, arguments->server);
        if (const auto& problem = server->data_port_problem(); !problem.empty()) {
          fmt::print(stderr, "warning: frames come from the command port: {}; some clients ignore them\n", problem);
        }
        return server;
      });
  command->add_option("--listen", arguments->listen, "ADDRESS:PORT for commands; port 0 = the system chooses")
      ->capture_default_str();
  command->add_option("--natnet-version", arguments->version, "of the bit stream: 3.0 to 4.1")->capture_default_str();
  command->add_option("--multicast", arguments->server.multicast_group,
                      "send frames to this group, such as 239.255.42.99 (default: unicast)");
  command
      ->add_option("--data-port", arguments->server.data_port,
                   "that frames come from; of the group, and for --to-data-port")
      ->capture_default_str();
  command->add_flag("--to-data-port", arguments->server.to_data_port,
                    "unicast frames go to the client's data port instead of the port that it commands from");
  command->add_option("--subject", arguments->server.marker_set, "name of the marker set")->capture_default_str();
}

}  // namespace risorius
