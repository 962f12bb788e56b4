// risorius serve livelink: a recording of the Live Link Face app, sent as the app would send it.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "capture/errors.h"
#include "replay/commands/command_serve.h"
#include "replay/live/live_link_sender.h"
#include "replay/takes/live_link_csv.h"

namespace risorius {
namespace {

struct LiveLinkArguments {
  std::string recording, target = "127.0.0.1:11111";
  double rate_hz = 0;
  bool one_byte_version = false;
  LiveLinkSenderOptions sender;
  PlayArguments play;
};

/// "ADDRESS" or "ADDRESS:PORT", an IPv6 address in brackets.
void read_target(std::string target, LiveLinkSenderOptions& options) {
  const auto colon = target.rfind(':');
  if (colon != std::string::npos && !target.ends_with(']')) {
    if (!CLI::detail::lexical_cast(target.substr(colon + 1), options.port)) {
      throw UserError("--to", "\"" + target + "\" has no port from 1 to 65535", "such as 127.0.0.1:11111");
    }
    target.resize(colon);
  }
  if (target.starts_with('[') && target.ends_with(']')) target = target.substr(1, target.size() - 2);
  options.address = target;
}

void serve(LiveLinkArguments& arguments) {
  const auto rate_hz = arguments.rate_hz > 0 ? std::optional(arguments.rate_hz) : std::nullopt;
  const LiveLinkTake take = load_live_link_csv(arguments.recording, rate_hz);
  for (const std::string& warning : take.warnings)
    fmt::print(stderr, "{}: warning: {}\n", arguments.recording, warning);
  read_target(arguments.target, arguments.sender);
  if (arguments.one_byte_version) arguments.sender.form = LiveLinkVersionForm::kByte;
  boost::asio::io_context io(1);
  LiveLinkSender sender(io, take, arguments.sender);
  LiveLinkTiming timing(arguments.recording, take);
  play_to_server(io, timing, sender, arguments.play, false,
                 fmt::format("sending {} to {}", arguments.recording, sender.endpoint()));
}

}  // namespace

void add_serve_livelink(CLI::App& serve_command) {
  auto arguments = std::make_shared<LiveLinkArguments>();
  CLI::App* command =
      serve_command.add_subcommand("livelink", "as the Live Link Face app, which sends without being asked");
  command->add_option("recording", arguments->recording, "CSV file of the app")->required();
  command->add_option("--to", arguments->target, "ADDRESS:PORT to send to")->capture_default_str();
  command->add_option("--device", arguments->sender.device, "subject name to send")->capture_default_str();
  command->add_option("--rate", arguments->rate_hz, "frames per second (default: what the timecodes say)")
      ->check(CLI::Range(1.0, 1000.0));
  command->add_option("--first-frame", arguments->sender.first_frame, "the first frame, counted since midnight")
      ->capture_default_str()
      ->check(CLI::Range(0, 86'399'999));
  command->add_flag("--one-byte-version", arguments->one_byte_version, "the version as one byte instead of four");
  arguments->play.add_to(*command);
  command->callback([arguments] { serve(*arguments); });
}

}  // namespace risorius
