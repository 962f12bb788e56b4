#include "capture/wire/zmq_source.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <fmt/format.h>
#include <optional>
#include <utility>
#include <zmq.hpp>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/curve_gate.h"

namespace risorius {
namespace {

using boost::asio::posix::stream_descriptor;
using boost::system::error_code;

constexpr std::size_t kMaxMessagesPerWakeUp = 128;
constexpr std::size_t kBufferBytes = 2048;
// A peer that announces more is cut off, before ZeroMQ allocates for it.
constexpr std::int64_t kMaxMessageBytes = 65536;
static_assert(kBufferBytes > kMaxDatagramBytes);

zmq::socket_t opened(zmq::context_t& context, const ZmqSourceOptions& options, CurveGate* gate) {
  if (options.high_water_mark < 1 || options.high_water_mark > 1'000'000) {
    throw UserError("high_water_mark", fmt::format("{} is out of range", options.high_water_mark), "1 to 1000000");
  }
  const bool pull = options.pattern == ZmqPattern::kPull;
  try {
    zmq::socket_t socket(context, pull ? zmq::socket_type::pull : zmq::socket_type::sub);
    socket.set(zmq::sockopt::rcvhwm, options.high_water_mark);
    socket.set(zmq::sockopt::maxmsgsize, kMaxMessageBytes);
    socket.set(zmq::sockopt::linger, 0);
    if (!pull) socket.set(zmq::sockopt::subscribe, "");
    if (gate != nullptr) gate->guard(socket);
    if (options.connect) {
      socket.connect(options.endpoint);
    } else {
      socket.bind(options.endpoint);
    }
    return socket;
  } catch (const zmq::error_t& error) {
    const bool busy = error.num() == EADDRINUSE;
    throw UserError(options.endpoint,
                    std::string(options.connect ? "cannot connect: " : "cannot listen: ") + error.what(),
                    busy ? "another program has this port: stop it or choose another port"
                         : "an endpoint looks like tcp://127.0.0.1:7001");
  }
}

std::optional<CurveGate> gate_of(boost::asio::io_context& io, zmq::context_t& context, const CurveServer& curve,
                                 SourceCounters& counters) {
  if (curve.keys.secret_key.empty()) return std::nullopt;
  return std::optional<CurveGate>(std::in_place, io, context, curve, counters.refused_connections);
}

}  // namespace

struct ZmqSource::Impl : std::enable_shared_from_this<ZmqSource::Impl> {
  Impl(boost::asio::io_context& io_context, const ZmqSourceOptions& options, std::function<void()> ready)
      : decoder(options.decoder),
        counters(decoder.counters()),
        gate(gate_of(io_context, context, options.curve, counters)),
        socket(opened(context, options, gate ? &*gate : nullptr)),
        endpoint(socket.get(zmq::sockopt::last_endpoint)),
        descriptor(io_context, socket.get(zmq::sockopt::fd)),
        io(io_context),
        on_ready(std::move(ready)) {}
  // ZeroMQ owns the file descriptor, Asio must not close it.
  ~Impl() { close(); }

  void close() noexcept {
    running = false;
    if (descriptor.is_open()) descriptor.release();
    socket.close();
  }

  void wait() {
    descriptor.async_wait(stream_descriptor::wait_read, [self = shared_from_this()](const error_code& error) {
      if (!error && self->running) self->drain();
    });
  }

  // ZMQ_FD is edge-triggered: it says once that something has changed. So we may wait for it only after a look at
  // ZMQ_EVENTS has found no input left; otherwise we come back by ourselves.
  void drain_later() {
    boost::asio::post(io, [self = shared_from_this()] {
      if (self->running) self->drain();
    });
  }

  bool has_input() { return (socket.get(zmq::sockopt::events) & ZMQ_POLLIN) != 0; }

  // False if there was no message.
  bool receive_message() noexcept {
    const int size = zmq_recv(socket.handle(), buffer.data(), buffer.size(), ZMQ_DONTWAIT);
    const std::int64_t receive_time_ns = monotonic_now_ns();
    if (size < 0) {
      if (errno != EAGAIN && errno != EINTR) counters.receive_errors.add();
      return false;
    }
    const auto bytes = static_cast<std::size_t>(size);
    if (bytes > buffer.size()) counters.truncated.add();
    const auto message = std::span<const std::byte>(buffer).first(std::min(bytes, buffer.size()));
    const std::uint64_t refused = counters.datagrams.refused.value();
    decoder.push(message, receive_time_ns);
    tap({message, RawOrigin{}, receive_time_ns, counters.datagrams.refused.value() > refused});
    counters.link = LinkState::kStreaming;
    return true;
  }

  void drain() {
    counters.wake_ups.add();
    for (std::size_t i = 0; i < kMaxMessagesPerWakeUp && decoder.ready() && receive_message(); ++i) {
    }
    on_ready();
    if (!running) return;
    paused = !decoder.ready();
    if (paused) {
      counters.pauses.add();
    } else if (has_input()) {
      drain_later();
    } else {
      wait();
    }
  }

  MarkerStreamDecoder decoder;
  SourceCounters& counters;
  zmq::context_t context{1};
  std::optional<CurveGate> gate;
  zmq::socket_t socket;
  std::string endpoint;
  stream_descriptor descriptor;
  boost::asio::io_context& io;
  std::function<void()> on_ready;
  RawTap tap;
  std::array<std::byte, kBufferBytes> buffer{};
  bool running = false, paused = false;
};

ZmqSource::ZmqSource(boost::asio::io_context& io, const ZmqSourceOptions& options, std::function<void()> on_ready)
    : impl_(std::make_shared<Impl>(io, options, std::move(on_ready))) {}

ZmqSource::~ZmqSource() { stop(); }

void ZmqSource::tap_raw(const RawTap& tap) noexcept { impl_->tap = tap; }

void ZmqSource::start() {
  if (impl_->running || !impl_->descriptor.is_open()) return;
  impl_->running = true;
  impl_->drain_later();  // what has come before now raises no further edge
}

void ZmqSource::stop() noexcept { impl_->close(); }

void ZmqSource::resume() {
  if (impl_->running && std::exchange(impl_->paused, false)) impl_->drain_later();
}

MarkerStreamDecoder& ZmqSource::decoder() noexcept { return impl_->decoder; }
bool ZmqSource::pop(SourceEvent& event) noexcept { return impl_->decoder.pop(event); }
void ZmqSource::flush() noexcept { impl_->decoder.flush(); }
const SourceCounters& ZmqSource::counters() const noexcept { return impl_->counters; }
std::string ZmqSource::endpoint() const { return "zmq+" + impl_->endpoint; }

}  // namespace risorius
