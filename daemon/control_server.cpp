#include "daemon/control_server.h"

#include <cerrno>
#include <nlohmann/json.hpp>

#include "capture/errors.h"

namespace risorius {
namespace {

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
    : socket_(context, zmq::socket_type::rep),
      handler_(std::move(handler)),
      readable_(io, socket_.get(zmq::sockopt::fd)) {
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
  serve();
}

ControlServer::~ControlServer() {
  readable_.cancel();
  readable_.release();
}

// The descriptor is edge-triggered: only after the socket was read empty may we wait for it again.
void ControlServer::wait() {
  readable_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                       [this](const boost::system::error_code& error) {
                         if (!error) serve();
                       });
}

void ControlServer::serve() {
  zmq::message_t message;
  while (socket_.recv(message, zmq::recv_flags::dontwait)) {
    nlohmann::json answer;
    try {
      answer = handler_(parse_request(message));
    } catch (const std::exception& error) {
      refused_.add();
      answer = {{"ok", false}, {"error", error.what()}};
    }
    const auto bytes = nlohmann::json::to_msgpack(answer);
    socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
  }
  wait();
}

}  // namespace risorius
