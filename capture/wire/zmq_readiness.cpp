#include "capture/wire/zmq_readiness.h"

#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <utility>

namespace risorius {

using boost::asio::posix::stream_descriptor;

struct ZmqReadiness::State : std::enable_shared_from_this<ZmqReadiness::State> {
  State(boost::asio::io_context& io_context, zmq::socket_t& socket, std::function<bool()> taking)
      : io(io_context), descriptor(io_context, socket.get(zmq::sockopt::fd)), take(std::move(taking)) {}
  ~State() { end(); }

  // ZeroMQ owns the file descriptor, Asio must not close it.
  void end() noexcept {
    running = false;
    if (descriptor.is_open()) descriptor.release();
  }

  // Others in the io_context have their turn in between.
  void look_later() {
    boost::asio::post(io, [self = shared_from_this()] {
      if (self->running) self->look();
    });
  }

  void look() {
    const bool more = take();
    if (!running) return;
    if (more) {
      look_later();
      return;
    }
    descriptor.async_wait(stream_descriptor::wait_read,
                          [self = shared_from_this()](const boost::system::error_code& error) {
                            if (!error && self->running) self->look();
                          });
  }

  boost::asio::io_context& io;
  stream_descriptor descriptor;
  std::function<bool()> take;
  bool running = true;
};

ZmqReadiness::ZmqReadiness(boost::asio::io_context& io, zmq::socket_t& socket, std::function<bool()> take)
    : state_(std::make_shared<State>(io, socket, std::move(take))) {
  state_->look_later();  // what has come before now raises no further edge
}

ZmqReadiness::~ZmqReadiness() { state_->end(); }

}  // namespace risorius
