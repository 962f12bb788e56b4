// The client's side of a running daemon: its messages and its control socket (daemon/README.md).
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <zmq.hpp>

#include "replay/live/live_view.h"

namespace risorius {

class DaemonSubscriber {
 public:
  /// Subscribes to all topics. Throws UserError if the endpoint is malformed.
  explicit DaemonSubscriber(const std::string& endpoint);
  /// Hands every message that comes within `wait` to the view.
  void receive_for(std::chrono::milliseconds wait, LiveView& view);

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

/// Sends one request and returns the answer. Throws UserError if there is none within `timeout`.
nlohmann::json ask_daemon(const std::string& endpoint, const nlohmann::json& request,
                          std::chrono::milliseconds timeout);

}  // namespace risorius
