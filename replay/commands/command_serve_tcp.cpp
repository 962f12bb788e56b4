// risorius serve qtm | vicon: the trackers whose clients connect by TCP.
#include <CLI/CLI.hpp>
#include <charconv>

#include "capture/errors.h"
#include "replay/commands/command_serve.h"
#include "replay/live/qtm_server.h"
#include "replay/live/vicon_server.h"

namespace risorius {
namespace {

struct TcpServeArguments {
  std::string listen;
  QtmServerOptions qtm;
  ViconServerOptions vicon;
};

/// "ADDRESS:PORT"
TcpServerOptions tcp_options_of(const std::string& listen) {
  const auto colon = listen.rfind(':');
  TcpServerOptions options;
  unsigned port = 65536;
  if (colon != std::string::npos) {
    options.address = listen.substr(0, colon);
    const char* end = listen.data() + listen.size();
    const auto read = std::from_chars(listen.data() + colon + 1, end, port);
    if (read.ec != std::errc() || read.ptr != end) port = 65536;
  }
  if (port > 65535) throw UserError("--listen " + listen, "is no ADDRESS:PORT", "such as 127.0.0.1:0 (any free port)");
  options.port = static_cast<std::uint16_t>(port);
  return options;
}

}  // namespace

void add_serve_qtm(CLI::App& serve) {
  auto arguments = std::make_shared<TcpServeArguments>();
  CLI::App* command = add_serve_protocol(serve, "qtm", "as Qualisys QTM (real-time protocol)",
                                         [arguments](boost::asio::io_context& io) {
                                           arguments->qtm.tcp = tcp_options_of(arguments->listen);
                                           return std::make_unique<QtmServer>(io, arguments->qtm);
                                         });
  arguments->listen = "127.0.0.1:22223";
  command->add_option("--listen", arguments->listen, "ADDRESS:PORT for clients")->capture_default_str();
  command->add_option("--newest-version", arguments->qtm.newest_minor, "n of the newest version 1.n to accept")
      ->capture_default_str()
      ->check(CLI::Range(1, 99));
}

void add_serve_vicon(CLI::App& serve) {
  auto arguments = std::make_shared<TcpServeArguments>();
  CLI::App* command = add_serve_protocol(serve, "vicon", "as Vicon Shogun, Nexus or Tracker (DataStream)",
                                         [arguments](boost::asio::io_context& io) {
                                           arguments->vicon.tcp = tcp_options_of(arguments->listen);
                                           return std::make_unique<ViconServer>(io, arguments->vicon);
                                         });
  arguments->listen = "127.0.0.1:801";
  command->add_option("--listen", arguments->listen, "ADDRESS:PORT for clients; 801 needs privileges on Unix")
      ->capture_default_str();
  command->add_option("--subject", arguments->vicon.subject, "name of the subject")->capture_default_str();
  command->add_flag("--y-up", arguments->vicon.y_up, "tell positions with Y up instead of Z");
}

}  // namespace risorius
