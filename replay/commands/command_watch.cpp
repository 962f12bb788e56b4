// risorius watch: a live table of a running daemon. risorius control: one control message and its answer.
#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <csignal>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/commands/commands.h"
#include "replay/commands/curve_arguments.h"
#include "replay/commands/number_check.h"
#include "replay/live/curve_refusal.h"
#include "replay/live/daemon_client.h"
#include "replay/live/live_table.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void watch(const std::string& endpoint, double seconds, const CurveArguments& curve) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  DaemonSubscriber subscriber(endpoint, curve.client());
  LiveTable table;
  const std::int64_t end_ns = seconds > 0 ? monotonic_now_ns() + static_cast<std::int64_t>(seconds * 1e9) : INT64_MAX;
  while (interrupted == 0 && monotonic_now_ns() < end_ns) {
    subscriber.receive_for(std::chrono::milliseconds(100), table.view());
    table.redraw();
  }
  if (const auto refusal = subscriber.refusal(); !refusal.empty()) throw UserError(endpoint, refusal, kCurveRemedy);
  if (table.view().status().is_null()) {
    throw UserError(endpoint, "nothing was published there",
                    "start risoriusd, or give its [output] publish address with --connect");
  }
}

void print_answer(const std::string& endpoint, const CurveArguments& curve, const nlohmann::json& request) {
  const nlohmann::json answer = ask_daemon(endpoint, request, std::chrono::seconds(3), curve.client());
  if (!answer.value("ok", false)) throw UserError(answer.value("error", "the daemon refused"));
  fmt::print("{}\n", answer.dump(1));
}

/// "AU12L=0.8" -> name and value.
std::pair<std::string, double> au_of_argument(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  double value = 0;
  const char* const end = argument.data() + argument.size();
  const char* const begin = equals == std::string::npos ? end : argument.data() + equals + 1;
  const auto [last, error] = std::from_chars(begin, end, value);
  if (equals == 0 || error != std::errc() || last != end)
    throw UserError("--au", "\"" + argument + "\" is no AU with its intensity", "write AU12L=0.8");
  return {argument.substr(0, equals), value};
}

struct TargetArguments {
  std::string expression, stream;
  std::vector<std::string> aus;
  std::string seconds = "1";  ///< or "auto"
  double hold_s = 1;
  std::optional<double> return_s;
};

nlohmann::json request_of(const TargetArguments& arguments) {
  if (arguments.expression.empty() == arguments.aus.empty())
    throw UserError("control target", "one target is needed",
                    "name an expression, or give --au AU12L=0.8 (several times)");
  nlohmann::json request{{"command", "go_to"}, {"stream", arguments.stream}, {"hold_seconds", arguments.hold_s}};
  if (const auto seconds = number_unless_auto(arguments.seconds)) {
    request["seconds"] = *seconds;
  } else {
    request["seconds"] = "auto";
  }
  if (arguments.return_s) request["return_seconds"] = *arguments.return_s;
  if (!arguments.expression.empty()) request["expression"] = arguments.expression;
  for (const std::string& au : arguments.aus) {
    const auto [name, value] = au_of_argument(au);
    request["au"][name] = value;
  }
  return request;
}

void add_target_commands(CLI::App& control, std::shared_ptr<std::string> endpoint,
                         std::shared_ptr<CurveArguments> curve) {
  CLI::App* target = control.add_subcommand("target", "lead what the topic `shown` shows to an expression, and back");
  auto arguments = std::make_shared<TargetArguments>();
  target->add_option("expression", arguments->expression, "happy, sad:2, ...: of the performer's table");
  target->add_option("--au", arguments->aus, "instead: AU12L=0.8; those that are not named become 0");
  target->add_option("--seconds", arguments->seconds, "of the way there; \"auto\": as long as a face takes")
      ->check(number_or_auto(0.01, 60))
      ->capture_default_str();
  target->add_option("--hold", arguments->hold_s, "seconds there")
      ->check(number_between(0, 3600))
      ->capture_default_str();
  target->add_option("--back", arguments->return_s, "seconds of the way back (default: as there)")
      ->check(number_between(0, 60));
  target->add_option("--stream", arguments->stream, "the source's name; may be left out if there is one source");
  target->callback([=] { print_answer(*endpoint, *curve, request_of(*arguments)); });

  CLI::App* release = control.add_subcommand("release", "end a target now: back to the face");
  auto stream = std::make_shared<std::string>();
  release->add_option("--stream", *stream, "the source's name; may be left out if there is one source");
  release->callback([=] { print_answer(*endpoint, *curve, {{"command", "release"}, {"stream", *stream}}); });
}

}  // namespace

void add_watch_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("watch", "live table of a running risoriusd");
  auto endpoint = std::make_shared<std::string>("tcp://127.0.0.1:7001");
  auto seconds = std::make_shared<double>(0);
  auto curve = std::make_shared<CurveArguments>();
  curve->add_to(*command);
  command->add_option("--connect", *endpoint, "the daemon's [output] publish address")->capture_default_str();
  command->add_option("--seconds", *seconds, "end after so long; 0 = until interrupted")
      ->check(number_between(0.0, 1e9))
      ->capture_default_str();
  command->callback([endpoint, seconds, curve] { watch(*endpoint, *seconds, *curve); });
}

void add_control_command(CLI::App& app) {
  CLI::App* control = app.add_subcommand("control", "send a control message to a running risoriusd");
  auto endpoint = std::make_shared<std::string>("tcp://127.0.0.1:7002");
  control->add_option("--connect", *endpoint, "the daemon's [output] control address")->capture_default_str();
  auto curve = std::make_shared<CurveArguments>();
  curve->add_to(*control);
  control->require_subcommand(1);
  control->fallthrough();  // --connect and the keys may stand behind the subcommand

  CLI::App* neutral = control->add_subcommand("neutral", "take the face as it is now for the neutral");
  auto stream = std::make_shared<std::string>();
  auto seconds = std::make_shared<double>(1);
  neutral->add_option("--stream", *stream, "the source's name; may be left out if there is one source");
  neutral->add_option("--seconds", *seconds, "of capture time to average")->capture_default_str();
  neutral->callback([=] {
    print_answer(*endpoint, *curve, {{"command", "capture_neutral"}, {"stream", *stream}, {"seconds", *seconds}});
  });
  add_target_commands(*control, endpoint, curve);
  control->add_subcommand("status", "print the counters")->callback([=] {
    print_answer(*endpoint, *curve, {{"command", "status"}});
  });
  control->add_subcommand("stop", "end the daemon, everything on disk")->callback([=] {
    print_answer(*endpoint, *curve, {{"command", "stop"}});
  });
}

}  // namespace risorius
