// risoriusd: the live service.
#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "capture/version.h"
#include "daemon/config.h"
#include "daemon/counter_table.h"
#include "daemon/service.h"
#include "daemon/status.h"
#include "daemon/terminal.h"
#include "daemon/time_slice.h"

int main(int argc, char** argv) {
  CLI::App app(
      "Risorius: live facial motion capture to FACS action units. Without a file: one UDP source, the built-in rig.");
  app.set_version_flag("--version", fmt::format("risoriusd {} ({})", risorius::kVersion, risorius::kInstructionSet));
  std::string path;
  bool print = false;
  app.add_option("--config", path, "TOML file; every key has a default");
  app.add_flag("--print-config", print, "print the effective configuration with the meaning of every key, and end");
  bool print_counters = false;
  app.add_flag("--print-counters", print_counters, "print what every counter of the status means, and end");
  CLI11_PARSE(app, argc, argv);
  if (print_counters) {
    fmt::print("{}", risorius::counter_tables_markdown());
    return 0;
  }
  // A file that may not grow is an error of the recorder's, not the end of the service.
  std::signal(SIGXFSZ, SIG_IGN);
  // Nor is a pipe whose reader has gone.
  std::signal(SIGPIPE, SIG_IGN);
  risorius::Terminal out(STDOUT_FILENO), log(STDERR_FILENO);
  try {
    const risorius::Config config = path.empty() ? risorius::default_config() : risorius::load_config(path);
    if (print) {
      fmt::print("{}", risorius::print_config(config));
      return 0;
    }
    risorius::ask_for_short_slices();
    risorius::Service service(config);
    // Beside what the status says: somebody may be looking at this terminal alone.
    service.on_notice([&log](const std::string& line) { log.say(line + "\n"); });
    for (std::size_t i = 0; i < config.sources.size(); ++i) {
      out.say(fmt::format("{}: listening on {}, rig {}\n", config.sources[i].name, service.input_endpoint(i),
                          config.sources[i].rig));
    }
    out.say(fmt::format("publishing on {}, control on {}\n", service.publish_endpoint(), service.control_endpoint()));
    service.run();
    out.say(risorius::summary_of(service.status()));
    if (const auto problem = service.recording_problem(); !problem.empty()) {
      log.say(fmt::format("risoriusd: recording: {}\n", problem));
      return 1;
    }
    return 0;
  } catch (const std::exception& error) {
    log.say(fmt::format("risoriusd: {}\n", error.what()));
    return 1;
  }
}
