// A risoriusd process on free ports of the loopback interface, for tests over real sockets.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "support/process.h"

namespace risorius::test {

enum class Recording : bool { kOff, kOn };

/// "" as the port's number means 0: the system chooses; endpoints are read from what the daemon prints.
class RunningDaemon {
 public:
  /// `sources` are [[source]] tables (TOML) with listen = "udp://127.0.0.1:0" or "zmq+tcp://127.0.0.1:0".
  RunningDaemon(const std::filesystem::path& folder, const std::string& sources, const std::string& more = "",
                Recording recording = Recording::kOn);

  /// Whether it came up and printed its endpoints.
  bool up() const noexcept { return up_; }
  std::string input(const std::string& source) const;
  std::string publish() const { return endpoint_after("publishing on "); }
  std::string control() const { return endpoint_after("control on "); }
  nlohmann::json status() const;

  /// SIGTERM, then everything it printed.
  Finished end();
  const std::filesystem::path& dataset() const noexcept { return dataset_; }
  Process& process() { return *process_; }

 private:
  std::string endpoint_after(const std::string& words) const;
  std::filesystem::path dataset_;
  std::unique_ptr<Process> process_;
  bool up_ = false;
};

}  // namespace risorius::test
