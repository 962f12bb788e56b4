#include "system/running_daemon.h"

#include <csignal>
#include <fstream>

#include "replay/live/daemon_client.h"

namespace risorius::test {

RunningDaemon::RunningDaemon(const std::filesystem::path& folder, const std::string& sources, const std::string& more,
                             Recording recording)
    : dataset_(folder / "dataset") {
  const auto config = folder / "daemon.toml";
  std::ofstream(config)
      << "[output]\npublish = \"tcp://127.0.0.1:*\"\ncontrol = \"tcp://127.0.0.1:*\"\nstatus_interval_s = 0.2\n"
      << "[record]\nfolder = \"" << (recording == Recording::kOn ? dataset_.string() : "") << "\"\n"
      << more << sources;
  process_ =
      std::make_unique<Process>(std::vector<std::string>{program("risoriusd").string(), "--config", config.string()});
  up_ = process_->wait_for_output("control on", 30) && process_->wait_for_output("\n", 5);
}

std::string RunningDaemon::endpoint_after(const std::string& words) const {
  const std::string& output = process_->output();
  const auto begin = output.find(words);
  if (begin == std::string::npos) return {};
  const auto from = begin + words.size();
  return output.substr(from, output.find_first_of(",\n", from) - from);
}

std::string RunningDaemon::input(const std::string& source) const { return endpoint_after(source + ": listening on "); }

nlohmann::json RunningDaemon::status() const {
  return ask_daemon(control(), {{"command", "status"}}, std::chrono::seconds(10)).at("status");
}

Finished RunningDaemon::end() {
  process_->send_signal(SIGTERM);
  return process_->finish(60);
}

}  // namespace risorius::test
