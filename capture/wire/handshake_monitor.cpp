#include "capture/wire/handshake_monitor.h"

#include <cstring>
#include <fmt/format.h>

namespace risorius {

HandshakeMonitor::HandshakeMonitor(zmq::context_t& context, zmq::socket_t& socket)
    : events_(context, zmq::socket_type::pair) {
  constexpr int kFailed =
      ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
  const std::string address = fmt::format("inproc://handshakes-{}", socket.handle());
  if (zmq_socket_monitor(socket.handle(), address.c_str(), ZMQ_EVENT_HANDSHAKE_SUCCEEDED | kFailed) != 0) {
    throw zmq::error_t();
  }
  // Without a bound: ZeroMQ's own thread, which carries the data, waits when its events are not taken.
  events_.set(zmq::sockopt::rcvhwm, 0);
  events_.set(zmq::sockopt::linger, 0);
  events_.connect(address);
}

Handshakes HandshakeMonitor::take() {
  Handshakes handshakes;
  zmq::message_t event, address;
  while (events_.recv(event, zmq::recv_flags::dontwait)) {
    if (event.more()) (void)events_.recv(address, zmq::recv_flags::none);  // parts come together
    std::uint16_t kind = 0;
    if (event.size() < sizeof kind) continue;
    std::memcpy(&kind, event.data(), sizeof kind);
    if (kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
      ++handshakes.succeeded;
    } else if (kind != ZMQ_EVENT_MONITOR_STOPPED) {
      ++handshakes.failed;
    }
  }
  return handshakes;
}

}  // namespace risorius
