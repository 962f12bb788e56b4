// A daemon with its own folder, and what measurements ask of it.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "support/process_usage.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {

inline std::string source_table(const std::string& name) {
  return "[[source]]\nname = \"" + name + "\"\nlisten = \"udp://127.0.0.1:0\"\n";
}

/// Throws std::runtime_error if it does not come up.
struct OwnDaemon {
  /// `record`: a session file.
  explicit OwnDaemon(const std::string& sources, bool record = false)
      : running(folder.path(), sources,
                record ? "session = \"" + (folder.path() / "session.mcap").string() + "\"\n" : "", Recording::kOff) {
    if (!running.up()) throw std::runtime_error("risoriusd did not start: " + running.process().output());
  }
  nlohmann::json stream(const std::string& name) const { return running.status().at("streams").at(name); }
  ProcessUsage usage() { return usage_of(running.process().id()); }
  TemporaryFolder folder;
  RunningDaemon running;
};

inline std::uint64_t number(const nlohmann::json& json, const char* path) {
  return json.at(nlohmann::json::json_pointer(path)).get<std::uint64_t>();
}

/// Frames and datagrams that are lost, by every counter of loss.
inline std::uint64_t gone(const nlohmann::json& stream) {
  return number(stream, "/frames/lost") + number(stream, "/reorder/late") + number(stream, "/admission/dropped") +
         number(stream, "/refused_frames") + number(stream, "/datagrams/kernel_drops");
}

/// Waits until `done` holds, at most a minute; false if it does not.
template <class Done>
bool wait_until(Done done) {
  for (int attempt = 0; attempt < 6000; ++attempt) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace risorius::test
