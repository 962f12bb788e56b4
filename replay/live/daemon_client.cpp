#include "replay/live/daemon_client.h"

#include <cerrno>
#include <zmq_addon.hpp>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/live/curve_refusal.h"

namespace risorius {
namespace {

constexpr int kHighWaterMark = 10'000;

void connect(zmq::socket_t& socket, const std::string& endpoint) {
  try {
    socket.connect(endpoint);
  } catch (const zmq::error_t& error) {
    throw UserError(endpoint, std::string("cannot be connected to: ") + error.what(),
                    "give an address such as tcp://127.0.0.1:7001");
  }
}

}  // namespace

DaemonSubscriber::DaemonSubscriber(const std::string& endpoint, const std::optional<CurveClient>& curve,
                                   const std::string& topic)
    : curve_(curve.has_value()), socket_(context_, zmq::socket_type::sub) {
  handshakes_.emplace(context_, socket_);
  if (curve) use_curve(socket_, *curve);
  socket_.set(zmq::sockopt::rcvhwm, kHighWaterMark);
  socket_.set(zmq::sockopt::subscribe, topic);
  connect(socket_, endpoint);
}

void DaemonSubscriber::receive_for(std::chrono::milliseconds wait, LiveView& view) {
  receive_for(wait, [&](const std::string& topic, const nlohmann::json& message) { view.update(topic, message); });
}

void DaemonSubscriber::receive_for(std::chrono::milliseconds wait, const Receiver& receiver) {
  const std::int64_t end_ns = monotonic_now_ns() + std::chrono::nanoseconds(wait).count();
  for (std::int64_t left = end_ns - monotonic_now_ns(); left > 0; left = end_ns - monotonic_now_ns()) {
    socket_.set(zmq::sockopt::rcvtimeo, static_cast<int>(left / 1'000'000 + 1));
    zmq::message_t topic, body;
    try {
      if (!socket_.recv(topic)) return;
      if (!topic.more() || !socket_.recv(body)) continue;
    } catch (const zmq::error_t& error) {
      if (error.num() == EINTR) return;  // a signal, which the caller looks at
      throw;
    }
    const auto* bytes = body.data<std::uint8_t>();
    const auto message = nlohmann::json::from_msgpack(bytes, bytes + body.size(), true, false);
    if (!message.is_object()) {  // of something that is no risoriusd
      ++malformed_;
      continue;
    }
    receiver(topic.to_string(), message);
  }
}

std::string DaemonSubscriber::refusal() { return curve_refusal(*handshakes_, curve_); }

nlohmann::json ask_daemon(const std::string& endpoint, const nlohmann::json& request, std::chrono::milliseconds timeout,
                          const std::optional<CurveClient>& curve) {
  zmq::context_t context;
  std::optional<HandshakeMonitor> handshakes;  // outlives the socket
  zmq::socket_t socket(context, zmq::socket_type::req);
  handshakes.emplace(context, socket);
  if (curve) use_curve(socket, *curve);
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::rcvtimeo, static_cast<int>(timeout.count()));
  connect(socket, endpoint);
  const auto bytes = nlohmann::json::to_msgpack(request);
  socket.send(zmq::buffer(bytes), zmq::send_flags::none);
  zmq::message_t answer;
  if (!socket.recv(answer)) {
    if (const auto refusal = curve_refusal(*handshakes, curve.has_value()); !refusal.empty()) {
      throw UserError(endpoint, refusal, kCurveRemedy);
    }
    throw UserError(endpoint, "no answer", "start risoriusd, or give its [output] control address with --connect");
  }
  const auto* data = answer.data<std::uint8_t>();
  return nlohmann::json::from_msgpack(data, data + answer.size());
}

}  // namespace risorius
