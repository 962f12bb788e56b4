// risorius chaos: a bad network between a sender and a receiver, with the truth of what it did.
#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/errors.h"
#include "replay/atomic_file.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/live/chaos_proxy.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

struct ChaosArguments {
  std::string listen, to, truth;
  std::vector<double> burst_ms_and_interval_s, delay_ms_and_jitter_ms;
  ChaosOptions options;
  bool quiet = false;
};

std::int64_t in_ns(double value, double ns_per_unit, const char* option) {
  if (!(value >= 0 && value * ns_per_unit <= 8.64e13)) {
    throw UserError(option, fmt::format("{} is out of range", value), "give 0 to a day");
  }
  return static_cast<std::int64_t>(std::round(value * ns_per_unit));
}

ChaosOptions options_of(const ChaosArguments& arguments) {
  ChaosOptions options = arguments.options;
  if (const auto& burst = arguments.burst_ms_and_interval_s; !burst.empty()) {
    options.burst_ns = in_ns(burst[0], 1e6, "--burst");
    if (burst.size() > 1) options.burst_interval_ns = in_ns(burst[1], 1e9, "--burst MS,MEAN_INTERVAL_S");
  }
  if (const auto& delay = arguments.delay_ms_and_jitter_ms; !delay.empty()) {
    options.delay_ns = in_ns(delay[0], 1e6, "--delay");
    if (delay.size() > 1) options.jitter_ns = in_ns(delay[1], 1e6, "--delay MS,JITTER_MS");
  }
  return options;
}

void show_progress(boost::asio::steady_timer& timer, ProgressLine& line, const ChaosProxy& proxy) {
  line.show(proxy.counts().received, 0);
  timer.expires_after(std::chrono::milliseconds(100));
  timer.async_wait([&](const boost::system::error_code& error) {
    if (!error) show_progress(timer, line, proxy);
  });
}

void run_chaos(const ChaosArguments& arguments) {
  if (arguments.listen == arguments.to) {
    throw UserError("--to", arguments.to + " is where --listen listens", "give the address of the receiver");
  }
  // Before anything runs: a truth that cannot be written would be known too late.
  std::optional<AtomicFile> truth_file;
  if (!arguments.truth.empty()) truth_file.emplace(arguments.truth);
  boost::asio::io_context io;
  ChaosProxy proxy(io, parse_listen_address(arguments.listen), parse_send_target(arguments.to), options_of(arguments));
  boost::asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const boost::system::error_code&, int) { io.stop(); });
  proxy.start();
  fmt::print(stderr, "chaos: listening on {}, sending to {}; Ctrl-C ends it\n", proxy.endpoint(), arguments.to);
  boost::asio::steady_timer timer(io);
  std::unique_ptr<ProgressLine> line;
  if (!arguments.quiet) {
    line = std::make_unique<ProgressLine>("chaos", "datagrams");
    show_progress(timer, *line, proxy);
  }
  io.run();
  proxy.stop();
  if (line) line->finish(proxy.counts().received);
  const std::string truth = proxy.truth().dump(1) + "\n";
  fmt::print("{}", truth);
  if (!truth_file) return;
  truth_file->write(truth);
  truth_file->commit();
}

}  // namespace

void add_chaos_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "chaos", "stand between a UDP sender and its receiver as a bad network, and tell the truth of what was done");
  auto arguments = std::make_shared<ChaosArguments>();
  ChaosOptions& options = arguments->options;
  command->add_option("--listen", arguments->listen, "udp://HOST:PORT for the sender; port 0: the system chooses")
      ->required();
  command->add_option("--to", arguments->to, "udp://HOST:PORT of the receiver")->required();
  const auto probability = [&](const char* name, double& value, const char* meaning) {
    command->add_option(name, value, meaning)->check(number_between(0, 1))->capture_default_str();
  };
  probability("--loss", options.loss, "probability that a datagram is lost: 0.05 is 5 %");
  probability("--reorder", options.reorder, "that it is held back until 1 to 3 more have come");
  probability("--duplicate", options.duplicate, "that it is sent twice");
  probability("--corrupt", options.corrupt, "that one of its bits is turned");
  command
      ->add_option("--burst", arguments->burst_ms_and_interval_s,
                   "MS[,MEAN_INTERVAL_S]: outages of MS in which all is lost, at random times, 5 s apart by default")
      ->delimiter(',')
      ->expected(1, 2);
  command->add_option("--delay", arguments->delay_ms_and_jitter_ms, "MS[,JITTER_MS]: of each datagram")
      ->delimiter(',')
      ->expected(1, 2);
  command->add_option("--seed", options.seed, "same seed and same datagrams: same faults")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--truth", arguments->truth, "JSON file for the truth, which is printed too");
  command->add_flag("--quiet", arguments->quiet, "no progress line");
  command->callback([arguments] { run_chaos(*arguments); });
}

}  // namespace risorius
