// The client's side of a running daemon: its messages and its control socket (daemon/README.md).
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "capture/wire/curve_keys.h"
#include "capture/wire/handshake_monitor.h"
#include "replay/live/live_view.h"

namespace risorius {

class DaemonSubscriber {
 public:
  /// `curve`: for a daemon with keys. `topic`: the only one, "" for all. Throws UserError if the endpoint is malformed.
  explicit DaemonSubscriber(const std::string& endpoint, const std::optional<CurveClient>& curve = {},
                            const std::string& topic = "");
  using Receiver = std::function<void(const std::string& topic, const nlohmann::json& message)>;
  /// Hands on every message that comes within `wait`.
  void receive_for(std::chrono::milliseconds wait, const Receiver& receiver);
  void receive_for(std::chrono::milliseconds wait, LiveView& view);
  /// Messages so far that were no topic with a map behind it; they were skipped.
  std::uint64_t malformed() const noexcept { return malformed_; }
  /// Why nothing can come: keys that do not fit. Empty if they do, or nobody is there.
  std::string refusal();

 private:
  zmq::context_t context_;
  bool curve_;
  std::uint64_t malformed_ = 0;
  std::optional<HandshakeMonitor> handshakes_;  ///< outlives the socket
  zmq::socket_t socket_;
};

/// Sends one request and returns the answer. Throws UserError if there is none within `timeout`.
nlohmann::json ask_daemon(const std::string& endpoint, const nlohmann::json& request, std::chrono::milliseconds timeout,
                          const std::optional<CurveClient>& curve = {});

}  // namespace risorius
