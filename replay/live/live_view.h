// What a terminal shows of a running daemon: rate, latency, loss, filled markers, strongest AUs. Fed by the messages of
// the daemon's PUB socket (daemon/README.md).
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace risorius {

class LiveView {
 public:
  /// One decoded message.
  void update(const std::string& topic, const nlohmann::json& message);

  /// The table as lines of at most 110 columns; one block per stream. `now_ns` is CLOCK_MONOTONIC.
  std::vector<std::string> lines(std::int64_t now_ns);

  /// The last status of all, as the daemon published it; null before the first.
  const nlohmann::json& status() const noexcept { return status_; }
  std::uint64_t au_messages() const noexcept { return au_messages_; }

 private:
  struct Stream {
    std::uint64_t frames = 0, frames_at_last_look = 0;
    std::uint64_t filled = 0, samples = 0;
    std::int64_t last_look_ns = 0;
    double rate_hz = 0;
    std::int64_t latest_latency_ns = 0;
    int looks_without_frames = 0;
    std::map<std::string, double> au;
    std::string status;
  };

  std::map<std::string, Stream> streams_;
  nlohmann::json status_;
  std::uint64_t au_messages_ = 0;
};

}  // namespace risorius
