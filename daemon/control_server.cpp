#include "daemon/control_server.h"

#include <boost/asio/post.hpp>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr int kRequestsPerWakeUp = 8;

/// MessagePack from programs, JSON from people with a terminal: a JSON object begins with '{', which no MessagePack map
/// does.
nlohmann::json parse_request(const zmq::message_t& message) {
  const auto* begin = message.data<std::uint8_t>();
  const auto* end = begin + message.size();
  auto request = message.size() > 0 && *begin == '{' ? nlohmann::json::parse(begin, end)
                                                     : nlohmann::json::from_msgpack(begin, end);
  if (!request.is_object() || !request.contains("command") || !request["command"].is_string()) {
    throw UserError("request", "is not a map with a text \"command\"",
                    "send {\"command\": \"status\"} as MessagePack or JSON");
  }
  return request;
}

}  // namespace

ControlServer::ControlServer(boost::asio::io_context& io, zmq::context_t& context, const std::string& endpoint,
                             Handler handler)
    : socket_(context, zmq::socket_type::rep), handler_(std::move(handler)), io_(io) {
  socket_.set(zmq::sockopt::linger, 200);
  // A request is short; and the MessagePack reader recurses, so the size also bounds its depth.
  socket_.set(zmq::sockopt::maxmsgsize, std::int64_t{4096});
  try {
    socket_.bind(endpoint);
  } catch (const zmq::error_t& error) {
    throw UserError("[output] control", "cannot bind \"" + endpoint + "\": " + error.what(),
                    error.num() == EADDRINUSE
                        ? "another program, perhaps another risoriusd, has this port: end it or choose another port"
                        : "give an address of this machine, such as \"tcp://127.0.0.1:7002\"");
  }
  endpoint_ = socket_.get(zmq::sockopt::last_endpoint);
  // Only now: Asio must never own, and close, the descriptor of a socket whose construction failed.
  readable_.emplace(io, socket_.get(zmq::sockopt::fd));
  serve();
}

ControlServer::~ControlServer() {
  boost::system::error_code ignored;
  readable_->cancel(ignored);
  readable_->release();
}

// The descriptor is edge-triggered: only after the socket was read empty may we wait for it again.
void ControlServer::wait() {
  readable_->async_wait(boost::asio::posix::stream_descriptor::wait_read,
                        [this](const boost::system::error_code& error) {
                          if (!error) serve();
                        });
}

void ControlServer::serve() {
  zmq::message_t message;
  for (int served = 0; served < kRequestsPerWakeUp; ++served) {
    try {
      if (!socket_.recv(message, zmq::recv_flags::dontwait)) {
        wait();
        return;
      }
      const bool whole = !message.more();
      zmq::message_t rest;
      while (socket_.get(zmq::sockopt::rcvmore)) (void)socket_.recv(rest, zmq::recv_flags::dontwait);
      const auto bytes = nlohmann::json::to_msgpack(answer_to(message, whole));
      socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
    } catch (const zmq::error_t&) {
      refused_.add();  // a peer's trouble must not become the service's
    }
  }
  // A flood of requests must not keep the frames of the same thread waiting.
  boost::asio::post(io_, [this] { serve(); });
}

nlohmann::json ControlServer::answer_to(const zmq::message_t& message, bool whole) {
  try {
    if (!whole) throw UserError("request", "has several parts", "send it as one message");
    return handler_(parse_request(message));
  } catch (const std::exception& error) {
    refused_.add();
    return {{"ok", false}, {"error", error.what()}};
  }
}

}  // namespace risorius
