#include "capture/wire/tcp_link.h"

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

#include "capture/monotonic_clock.h"
#include "capture/wire/receive_batch.h"

namespace risorius {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

/// One busy connection must not keep the others from their turn.
constexpr std::size_t kMaxReadsPerWakeUp = 16;

}  // namespace

struct TcpLink::Impl : std::enable_shared_from_this<TcpLink::Impl> {
  enum class State { kOff, kWaiting, kConnecting, kConnected };

  Impl(boost::asio::io_context& io, const TcpLinkOptions& chosen, Handlers given)
      : options(chosen),
        handlers(std::move(given)),
        resolver(io),
        socket(io),
        timer(io),
        buffer(chosen.read_buffer_bytes),
        wait_ns(chosen.first_wait_ns) {}

  void connect() {
    state = State::kConnecting;
    const auto attempt = ++attempts;
    arm(options.connect_timeout_ns, [this, attempt] {
      if (attempt == attempts && state == State::kConnecting) fail();
    });
    resolver.async_resolve(options.host, std::to_string(options.port),
                           [self = shared_from_this(), attempt](const error_code& error, const auto& found) {
                             if (attempt != self->attempts || self->state != State::kConnecting) return;
                             if (error) return self->fail();
                             self->connect_to(found, attempt);
                           });
  }

  void connect_to(const tcp::resolver::results_type& found, std::uint64_t attempt) {
    boost::asio::async_connect(socket, found,
                               [self = shared_from_this(), attempt](const error_code& error, const tcp::endpoint&) {
                                 if (attempt != self->attempts || self->state != State::kConnecting) return;
                                 if (error) return self->fail();
                                 self->begin();
                               });
  }

  void begin() {
    state = State::kConnected;
    timer.cancel();
    error_code ignored;
    socket.non_blocking(true, ignored);
    socket.set_option(tcp::no_delay(true), ignored);
    counters.granted_buffer_bytes.set(prepare_receive_buffer(socket.native_handle(), options.receive_buffer_bytes));
    filled = 0;
    queue.clear();
    paused = refused = false;
    counters.connections.add();
    handlers.connected();
    if (state == State::kConnected) wait_to_read();
  }

  /// From any state but off: closes, tells, and tries again after a while.
  void fail() {
    const bool was_connected = state == State::kConnected;
    ++attempts;
    counters.failures.add();
    close();
    state = State::kWaiting;
    if (was_connected) handlers.lost();
    if (state != State::kWaiting) return;
    arm(wait_ns, [this] {
      if (state == State::kWaiting) connect();
    });
    wait_ns = std::min(2 * wait_ns, options.longest_wait_ns);
  }

  void close() noexcept {
    error_code ignored;
    resolver.cancel();
    socket.close(ignored);
    writing = false;
  }

  template <class Then>
  void arm(std::int64_t after_ns, Then then) {
    timer.expires_after(std::chrono::nanoseconds(after_ns));
    timer.async_wait([self = shared_from_this(), then](const error_code& error) {
      if (!error && self->state != State::kOff) then();
    });
  }

  void wait_to_read() {
    socket.async_wait(tcp::socket::wait_read, [self = shared_from_this(), attempt = attempts](const error_code& error) {
      if (attempt != self->attempts || self->state != State::kConnected) return;
      if (error) return self->fail();
      self->read();
    });
  }

  void read() {
    counters.wake_ups.add();
    error_code error;
    for (std::size_t i = 0; i < kMaxReadsPerWakeUp; ++i) {
      const std::size_t room = buffer.size() - filled;
      if (room == 0) break;
      const std::size_t size = socket.read_some(boost::asio::buffer(buffer.data() + filled, room), error);
      const std::int64_t time_ns = monotonic_now_ns();
      if (error) break;
      filled += size;
      receive_time_ns = time_ns;
      if (!offer() || size < room) break;
    }
    finish_round(error && error != boost::asio::error::would_block && error != boost::asio::error::try_again &&
                 error != boost::asio::error::interrupted);
  }

  /// False if the consumer has no room, the buffer is full or the connection is gone.
  bool offer() {
    const auto attempt = attempts;
    const auto used = handlers.received(std::span<const std::byte>(buffer).first(filled), receive_time_ns);
    if (attempt != attempts || state != State::kConnected) return false;
    refused = !used;
    if (refused) return false;
    std::memmove(buffer.data(), buffer.data() + *used, filled - *used);
    filled -= *used;
    return filled < buffer.size();
  }

  void finish_round(bool broken) {
    const auto attempt = attempts;
    const auto here = [&] { return attempt == attempts && state == State::kConnected; };
    bool go_on = handlers.round_done();
    // What the consumer had no room for before it popped.
    for (std::size_t before = filled + 1; here() && go_on && filled > 0 && filled < before;) {
      before = filled;
      offer();
      if (here() && filled < before) go_on = handlers.round_done();
    }
    if (!here()) return;
    if (broken) return fail();
    paused = !go_on || refused;
    if (!paused) wait_to_read();
  }

  void send(std::span<const std::byte> bytes) {
    if (state != State::kConnected) return;
    if (queue.size() + bytes.size() > options.write_queue_bytes) return drop();
    queue.insert(queue.end(), bytes.begin(), bytes.end());
    if (!writing) write();
  }

  void write() {
    error_code error;
    const std::size_t size = socket.write_some(boost::asio::buffer(queue.data(), queue.size()), error);
    if (!error) queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(size));
    if (error && error != boost::asio::error::would_block && error != boost::asio::error::try_again) return drop();
    writing = !queue.empty();
    if (!writing) return;
    socket.async_wait(tcp::socket::wait_write,
                      [self = shared_from_this(), attempt = attempts](const error_code& failed) {
                        if (attempt != self->attempts || self->state != State::kConnected) return;
                        if (failed) return self->fail();
                        self->write();
                      });
  }

  void drop() {
    boost::asio::post(socket.get_executor(), [self = shared_from_this(), attempt = attempts] {
      if (attempt == self->attempts && self->state == State::kConnected) self->fail();
    });
  }

  TcpLinkOptions options;
  Handlers handlers;
  tcp::resolver resolver;
  tcp::socket socket;
  boost::asio::steady_timer timer;
  std::vector<std::byte> buffer;  ///< the first `filled` bytes are in use
  std::size_t filled = 0;
  std::vector<std::byte> queue;
  std::int64_t receive_time_ns = 0, wait_ns;
  std::uint64_t attempts = 0;  ///< tells handlers of an earlier connection from those of this one
  State state = State::kOff;
  bool writing = false, paused = false, refused = false;
  TcpLinkCounters counters;
};

TcpLink::TcpLink(boost::asio::io_context& io, const TcpLinkOptions& options, Handlers handlers)
    : impl_(std::make_shared<Impl>(io, options, std::move(handlers))) {}

TcpLink::~TcpLink() { stop(); }

void TcpLink::start() {
  if (impl_->state == Impl::State::kOff) impl_->connect();
}

void TcpLink::stop() noexcept {
  impl_->state = Impl::State::kOff;
  ++impl_->attempts;
  impl_->timer.cancel();
  impl_->close();
}

void TcpLink::resume() {
  if (impl_->state != Impl::State::kConnected || !std::exchange(impl_->paused, false)) return;
  impl_->offer();
  if (impl_->state == Impl::State::kConnected) impl_->finish_round(false);
}

void TcpLink::drop() { impl_->drop(); }
void TcpLink::healthy() noexcept { impl_->wait_ns = impl_->options.first_wait_ns; }
void TcpLink::send(std::span<const std::byte> bytes) { impl_->send(bytes); }
bool TcpLink::connected() const noexcept { return impl_->state == Impl::State::kConnected; }
const TcpLinkCounters& TcpLink::counters() const noexcept { return impl_->counters; }

std::string TcpLink::local_address() const {
  error_code error;
  const auto endpoint = impl_->socket.local_endpoint(error);
  return error ? "" : endpoint.address().to_string();
}

std::string TcpLink::peer_address() const {
  error_code error;
  const auto endpoint = impl_->socket.remote_endpoint(error);
  return error ? "" : endpoint.address().to_string();
}

}  // namespace risorius
