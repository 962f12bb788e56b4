#include "capture/wire/udp_source.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cerrno>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/receive_batch.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 32;
constexpr std::size_t kMaxBatchesPerWakeUp = 4;
constexpr std::size_t kSlotBytes = 2048;
static_assert(kSlotBytes > kMaxDatagramBytes);

udp::socket bound_socket(boost::asio::io_context& io, const UdpSourceOptions& options) {
  const std::string place = fmt::format("udp://{}:{}", options.address, options.port);
  error_code error;
  const auto address = boost::asio::ip::make_address(options.address, error);
  if (error) throw UserError(place, "the address is no IP address", "use 127.0.0.1, or 0.0.0.0 for all interfaces");
  const udp::endpoint endpoint(address, options.port);
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

struct UdpSource::Impl : std::enable_shared_from_this<UdpSource::Impl> {
  Impl(boost::asio::io_context& io, const UdpSourceOptions& options, std::function<void()> ready)
      : decoder(options.decoder),
        socket(bound_socket(io, options)),
        on_ready(std::move(ready)),
        counters(decoder.counters()) {
    port = socket.local_endpoint().port();
    address = socket.local_endpoint().address().to_string();
    if (socket.local_endpoint().address().is_v6()) address = "[" + address + "]";
    counters.granted_buffer_bytes.set(prepare_receive_buffer(socket.native_handle(), options.receive_buffer_bytes));
  }

  void wait() {
    socket.async_wait(udp::socket::wait_read, [self = shared_from_this()](const error_code& error) {
      if (!error && self->running) self->drain();
    });
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
    for (std::size_t i = 0; i < count; ++i) {
      if (batch.truncated(i)) counters.truncated.add();
      const std::uint32_t drops = batch.drops(i, known_drops);
      counters.kernel_drops.add(drops - known_drops);  // modulo 2^32, as the kernel counts
      known_drops = drops;
      decoder.push(batch.datagram(i), receive_time_ns);
    }
    if (count > 0) counters.link = LinkState::kStreaming;
    return count == limit;
  }

  void drain() {
    counters.wake_ups.add();
    for (std::size_t i = 0; i < kMaxBatchesPerWakeUp && receive_batch(); ++i) {
    }
    on_ready();
    if (!running) return;
    paused = !decoder.ready();
    if (paused) {
      counters.pauses.add();
    } else {
      wait();
    }
  }

  MarkerStreamDecoder decoder;
  udp::socket socket;
  std::function<void()> on_ready;
  ReceiveBatch batch{kBatch, kSlotBytes};
  SourceCounters& counters;
  std::uint32_t known_drops = 0;
  std::string address;
  std::uint16_t port = 0;
  bool running = false, paused = false;
};

namespace {

const UdpSourceOptions& checked(const UdpSourceOptions& options) {
  if (options.receive_buffer_bytes < 1024 || options.receive_buffer_bytes > (std::size_t{1} << 30)) {
    throw UserError("receive_buffer_bytes", fmt::format("{} is out of range", options.receive_buffer_bytes),
                    "1024 to 1073741824 bytes");
  }
  return options;
}

}  // namespace

UdpSource::UdpSource(boost::asio::io_context& io, const UdpSourceOptions& options, std::function<void()> on_ready)
    : impl_(std::make_shared<Impl>(io, checked(options), std::move(on_ready))) {}

UdpSource::~UdpSource() { stop(); }

void UdpSource::start() {
  if (impl_->running || !impl_->socket.is_open()) return;
  impl_->running = true;
  impl_->wait();
}

void UdpSource::stop() noexcept {
  impl_->running = false;
  error_code ignored;
  impl_->socket.close(ignored);
}

void UdpSource::resume() {
  if (impl_->running && std::exchange(impl_->paused, false)) impl_->wait();
}

MarkerStreamDecoder& UdpSource::decoder() noexcept { return impl_->decoder; }
bool UdpSource::pop(SourceEvent& event) noexcept { return impl_->decoder.pop(event); }
void UdpSource::flush() noexcept { impl_->decoder.flush(); }
const SourceCounters& UdpSource::counters() const noexcept { return impl_->counters; }
std::uint16_t UdpSource::port() const noexcept { return impl_->port; }
std::string UdpSource::endpoint() const { return fmt::format("udp://{}:{}", impl_->address, impl_->port); }

}  // namespace risorius
