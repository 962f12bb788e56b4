// Answers control messages on a ZeroMQ REP socket, on the I/O thread. A message is a MessagePack (or JSON) map with
// "command"; the answer is a MessagePack map with "ok" and, if it is false, "error". daemon/README.md lists the
// commands.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "capture/counters.h"
#include "capture/wire/curve_gate.h"

namespace risorius {

class ControlServer {
 public:
  /// What a command does: the answer's map, or an exception whose text becomes the error.
  using Handler = std::function<nlohmann::json(const nlohmann::json& request)>;

  /// `gate` may be null. Throws UserError if the endpoint cannot be bound.
  ControlServer(boost::asio::io_context& io, zmq::context_t& context, const std::string& endpoint, CurveGate* gate,
                Handler handler);

  const std::string& endpoint() const noexcept { return endpoint_; }
  std::uint64_t refused() const noexcept { return refused_.value(); }

 private:
  bool serve();
  nlohmann::json answer_to(const zmq::message_t& message, bool whole);

  zmq::socket_t socket_;
  Handler handler_;
  std::string endpoint_;
  Counter refused_;
  std::optional<ZmqReadiness> readiness_;
};

}  // namespace risorius
