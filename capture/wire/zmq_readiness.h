// Waits in an io_context for input of a ZeroMQ socket. ZMQ_FD is edge-triggered: it says once that something has
// changed, so one may wait for it only after the socket was found empty.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <zmq.hpp>

namespace risorius {

class ZmqReadiness {
 public:
  /// `take`: takes a bounded number of messages; returns false if it found the socket empty. Called in the io_context
  /// only, first soon after construction. The socket must outlive this object.
  ZmqReadiness(boost::asio::io_context& io, zmq::socket_t& socket, std::function<bool()> take);
  /// `take` is not called any more.
  ~ZmqReadiness();
  ZmqReadiness(const ZmqReadiness&) = delete;
  ZmqReadiness& operator=(const ZmqReadiness&) = delete;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared with the handler that waits in the io_context
};

}  // namespace risorius
