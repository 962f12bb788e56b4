// Lets only those in who have the right key: makes the sockets of one ZeroMQ context CURVE servers, answers ZeroMQ's
// questions who may connect (ZAP, rfc.zeromq.org/spec/27), and counts those who were refused.
#pragma once

#include <boost/asio/io_context.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <zmq.hpp>

#include "capture/counters.h"
#include "capture/wire/curve_keys.h"
#include "capture/wire/handshake_monitor.h"
#include "capture/wire/zmq_readiness.h"

namespace risorius {

class CurveGate {
 public:
  /// One per context. Answers on the io_context: while that does not run nobody on a list is let in.
  /// `refused` counts connections that were not let in: wrong key, no key, or no handshake at all.
  CurveGate(boost::asio::io_context& io, zmq::context_t& context, CurveServer server, Counter& refused);

  /// Before the socket binds. It must be closed before the gate is destroyed.
  void guard(zmq::socket_t& socket);

 private:
  struct Guarded {
    Guarded(zmq::context_t& context, zmq::socket_t& socket) : monitor(context, socket) {}
    HandshakeMonitor monitor;
    std::optional<ZmqReadiness> readiness;
  };

  bool answer_one();

  boost::asio::io_context& io_;
  zmq::context_t& context_;
  CurveServer server_;
  Counter& refused_;
  zmq::socket_t questions_;  ///< ZAP; only with a list of clients
  std::optional<ZmqReadiness> asked_;
  std::deque<Guarded> guarded_;
};

}  // namespace risorius
