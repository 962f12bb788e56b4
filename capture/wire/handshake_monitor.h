// Counts how the handshakes of a ZeroMQ socket's connections end. One thread, which need not be the socket's.
#pragma once

#include <cstdint>
#include <zmq.hpp>

namespace risorius {

struct Handshakes {
  std::uint64_t succeeded = 0;
  std::uint64_t failed = 0;  ///< wrong key, no key, no ZeroMQ at all, or gone too early; a client tries again by itself
};

class HandshakeMonitor {
 public:
  /// On the socket's thread, before it binds or connects. The socket must be closed before this object is destroyed.
  HandshakeMonitor(zmq::context_t& context, zmq::socket_t& socket);

  /// Those since the last call; never waits.
  Handshakes take();
  /// Of the events' own socket, to wait for news.
  zmq::socket_t& events() noexcept { return events_; }

 private:
  zmq::socket_t events_;
};

}  // namespace risorius
