// risorius watch: a live table of a running daemon. risorius control: one control message and its answer.
#include <CLI/CLI.hpp>
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
  fmt::print("{}\n", answer.dump(1));
  if (!answer.value("ok", false)) throw UserError(answer.value("error", "the daemon refused"));
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
  control->add_subcommand("status", "print the counters")->callback([=] {
    print_answer(*endpoint, *curve, {{"command", "status"}});
  });
  control->add_subcommand("stop", "end the daemon, everything on disk")->callback([=] {
    print_answer(*endpoint, *curve, {{"command", "stop"}});
  });
}

}  // namespace risorius
