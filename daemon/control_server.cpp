#include "daemon/control_server.h"

#include <cerrno>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "capture/utf8.h"
#include "daemon/control_request.h"

namespace risorius {
namespace {

constexpr int kRequestsPerWakeUp = 8;
constexpr int kHighWaterMark = 100;  // requests of a peer that waits for no answer

}  // namespace

ControlServer::ControlServer(boost::asio::io_context& io, zmq::context_t& context, const std::string& endpoint,
                             CurveGate* gate, Handler handler)
    : socket_(context, zmq::socket_type::rep), handler_(std::move(handler)) {
  socket_.set(zmq::sockopt::linger, 200);
  socket_.set(zmq::sockopt::rcvhwm, kHighWaterMark);
  socket_.set(zmq::sockopt::sndhwm, kHighWaterMark);
  // Longer than what is answered, so that a request that is a little too long is told so; beyond, ZeroMQ hangs up.
  socket_.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(16 * kMostRequestBytes));
  if (gate != nullptr) gate->guard(socket_);
  try {
    socket_.bind(endpoint);
  } catch (const zmq::error_t& error) {
    throw UserError("[output] control", "cannot bind \"" + endpoint + "\": " + error.what(),
                    error.num() == EADDRINUSE
                        ? "another program, perhaps another risoriusd, has this port: end it or choose another port"
                        : "give an address of this machine, such as \"tcp://127.0.0.1:7002\"");
  }
  endpoint_ = socket_.get(zmq::sockopt::last_endpoint);
  readiness_.emplace(io, socket_, [this] { return serve(); });
}

bool ControlServer::serve() {
  zmq::message_t message;
  // A flood of requests must not keep the frames of the same thread waiting.
  for (int served = 0; served < kRequestsPerWakeUp; ++served) {
    try {
      if (!socket_.recv(message, zmq::recv_flags::dontwait)) return false;
      const bool whole = !message.more();
      zmq::message_t rest;
      while (socket_.get(zmq::sockopt::rcvmore)) (void)socket_.recv(rest, zmq::recv_flags::dontwait);
      const auto bytes = nlohmann::json::to_msgpack(answer_to(message, whole));
      socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
    } catch (const zmq::error_t&) {
      refused_.add();  // a peer's trouble must not become the service's
    }
  }
  return true;
}

nlohmann::json ControlServer::answer_to(const zmq::message_t& message, bool whole) {
  try {
    if (!whole) throw UserError("request", "has several parts", "send it as one message");
    if (message.size() > kMostRequestBytes) {
      throw UserError("request", fmt::format("has {} bytes", message.size()),
                      fmt::format("{} are enough for any", kMostRequestBytes));
    }
    return handler_(parse_control_request({message.data<std::byte>(), message.size()}));
  } catch (const std::exception& error) {
    refused_.add();
    // It may repeat bytes of the request that are no UTF-8; the answer must be some, or its reader fails.
    return {{"ok", false}, {"error", utf8_of(error.what())}};
  }
}

}  // namespace risorius
