#include "capture/wire/udp_source.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/flood_rest.h"
#include "capture/wire/receive_batch.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 32;
constexpr std::size_t kMaxBatchesPerWakeUp = 4;
constexpr std::size_t kSlotBytes = 2048;
static_assert(kSlotBytes > kMaxDatagramBytes);

constexpr std::string_view scheme_of(const MarkerStreamDecoder&) { return "udp"; }
constexpr std::string_view scheme_of(const LiveLinkSession&) { return "livelink"; }

udp::socket bound_socket(boost::asio::io_context& io, std::string_view scheme, const std::string& host,
                         std::uint16_t port) {
  const std::string place = fmt::format("{}://{}:{}", scheme, host, port);
  error_code error;
  const auto address = boost::asio::ip::make_address(host, error);
  if (error) throw UserError(place, "the address is no IP address", "use 127.0.0.1, or 0.0.0.0 for all interfaces");
  const udp::endpoint endpoint(address, port);
  udp::socket socket(io);
  socket.open(endpoint.protocol(), error);
  if (!error) socket.bind(endpoint, error);
  if (!error) return socket;
  const bool busy = error == boost::asio::error::address_in_use;
  throw UserError(place, "cannot listen: " + error.message(),
                  busy ? "another program has this port: stop it or choose another port"
                       : "choose an address of this machine and a port above 1023");
}

}  // namespace

template <class Decoder, class Options>
struct UdpSourceOf<Decoder, Options>::Impl : std::enable_shared_from_this<Impl> {
  Impl(boost::asio::io_context& io, const UdpSourceOptionsOf<Options>& options, std::function<void()> ready)
      : decoder(options.decoder),
        socket(bound_socket(io, scheme_of(decoder), options.address, options.port)),
        rest_timer(io),
        on_ready(std::move(ready)),
        counters(decoder.counters()) {
    port = socket.local_endpoint().port();
    address = socket.local_endpoint().address().to_string();
    if (socket.local_endpoint().address().is_v6()) address = "[" + address + "]";
    counters.granted_buffer_bytes.set(prepare_receive_buffer(socket.native_handle(), options.receive_buffer_bytes));
  }

  void wait() {
    socket.async_wait(udp::socket::wait_read, [self = this->shared_from_this()](const error_code& error) {
      if (!error && self->running) self->drain();
    });
  }

  /// After a full turn: at once, or after a rest if it brought nothing of use.
  void wait_for_turn(bool was_useless) {
    const auto time = rest.after_turn(was_useless);
    if (time.count() == 0) return wait();
    counters.rests.add();
    rest_timer.expires_after(time);
    rest_timer.async_wait([self = this->shared_from_this()](const error_code& error) {
      if (!error && self->running) self->drain();
    });
  }

  std::uint64_t useless() const noexcept {
    return counters.datagrams.refused.value() + counters.datagrams.dropped.value();
  }

  // True if the socket may have more.
  bool receive_batch() noexcept {
    const std::size_t limit = std::min(kBatch, decoder.datagrams_until_full());
    if (limit == 0) return false;
    const int received = batch.receive(socket.native_handle(), limit);
    const std::int64_t receive_time_ns = monotonic_now_ns();
    if (received < 0) {
      if (errno != EAGAIN && errno != EINTR) counters.receive_errors.add();
      return false;
    }
    const auto count = static_cast<std::size_t>(received);
    const std::uint64_t refused_before = counters.datagrams.refused.value();
    for (std::size_t i = 0; i < count; ++i) {
      if (batch.truncated(i)) counters.truncated.add();
      const std::uint32_t drops = batch.drops(i, known_drops);
      counters.kernel_drops.add(drops - known_drops);  // modulo 2^32, as the kernel counts
      known_drops = drops;
      const std::uint64_t refused = counters.datagrams.refused.value();
      decoder.push(batch.datagram(i), receive_time_ns);
      tap(batch.datagram(i), batch.sender(i), receive_time_ns, counters.datagrams.refused.value() > refused);
    }
    // Garbage is no sign of a sender.
    if (counters.datagrams.refused.value() - refused_before < count) counters.link = LinkState::kStreaming;
    return count == limit;
  }

  void drain() {
    counters.wake_ups.add();
    const std::uint64_t received_before = counters.datagrams.received.value(), useless_before = useless();
    bool more = true;
    for (std::size_t i = 0; i < kMaxBatchesPerWakeUp && more; ++i) more = receive_batch();
    const bool was_useless =
        more && useless() - useless_before >= counters.datagrams.received.value() - received_before;
    on_ready();
    if (!running) return;
    paused = !decoder.ready();
    if (paused) {
      counters.pauses.add();
    } else {
      wait_for_turn(was_useless);
    }
  }

  Decoder decoder;
  udp::socket socket;
  boost::asio::steady_timer rest_timer;
  FloodRest rest;
  std::function<void()> on_ready;
  ReceiveBatch batch{kBatch, kSlotBytes};
  SourceCounters& counters;
  RawTap tap;
  std::uint32_t known_drops = 0;
  std::string address;
  std::uint16_t port = 0;
  bool running = false, paused = false;
};

namespace {

void check_receive_buffer(std::size_t bytes) {
  if (bytes >= 1024 && bytes <= (std::size_t{1} << 30)) return;
  throw UserError("receive_buffer_bytes", fmt::format("{} is out of range", bytes), "1024 to 1073741824 bytes");
}

template <class Options>
const UdpSourceOptionsOf<Options>& checked(const UdpSourceOptionsOf<Options>& options) {
  check_receive_buffer(options.receive_buffer_bytes);
  return options;
}

}  // namespace

template <class Decoder, class Options>
UdpSourceOf<Decoder, Options>::UdpSourceOf(boost::asio::io_context& io, const UdpSourceOptionsOf<Options>& options,
                                           std::function<void()> on_ready)
    : impl_(std::make_shared<Impl>(io, checked(options), std::move(on_ready))) {}

template <class Decoder, class Options>
UdpSourceOf<Decoder, Options>::~UdpSourceOf() {
  stop();
}

template <class Decoder, class Options>
void UdpSourceOf<Decoder, Options>::tap_raw(const RawTap& tap) noexcept {
  impl_->tap = tap;
}

template <class Decoder, class Options>
void UdpSourceOf<Decoder, Options>::start() {
  if (impl_->running || !impl_->socket.is_open()) return;
  impl_->running = true;
  impl_->wait();
}

template <class Decoder, class Options>
void UdpSourceOf<Decoder, Options>::stop() noexcept {
  impl_->running = false;
  error_code ignored;
  impl_->socket.close(ignored);
  impl_->rest_timer.cancel();
}

template <class Decoder, class Options>
void UdpSourceOf<Decoder, Options>::resume() {
  if (impl_->running && std::exchange(impl_->paused, false)) impl_->wait();
}

template <class Decoder, class Options>
Decoder& UdpSourceOf<Decoder, Options>::decoder() noexcept {
  return impl_->decoder;
}
template <class Decoder, class Options>
bool UdpSourceOf<Decoder, Options>::pop(SourceEvent& event) noexcept {
  return impl_->decoder.pop(event);
}
template <class Decoder, class Options>
void UdpSourceOf<Decoder, Options>::flush() noexcept {
  impl_->decoder.flush();
}
template <class Decoder, class Options>
const SourceCounters& UdpSourceOf<Decoder, Options>::counters() const noexcept {
  return impl_->counters;
}
template <class Decoder, class Options>
std::uint16_t UdpSourceOf<Decoder, Options>::port() const noexcept {
  return impl_->port;
}
template <class Decoder, class Options>
std::string UdpSourceOf<Decoder, Options>::endpoint() const {
  return fmt::format("{}://{}:{}", scheme_of(impl_->decoder), impl_->address, impl_->port);
}

template class UdpSourceOf<MarkerStreamDecoder, DecoderOptions>;
template class UdpSourceOf<LiveLinkSession, LiveLinkOptions>;

}  // namespace risorius
