#include "capture/wire/udp_source.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <utility>
#include <vector>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 32;
constexpr std::size_t kMaxBatchesPerWakeUp = 4;
constexpr std::size_t kSlotBytes = 2048;
static_assert(kSlotBytes > kMaxDatagramBytes);

// What one recvmmsg call fills.
class ReceiveBatch {
 public:
  ReceiveBatch() {
    for (std::size_t i = 0; i < kBatch; ++i) {
      parts_[i] = {.iov_base = bytes_[i].data(), .iov_len = kSlotBytes};
      messages_[i].msg_hdr.msg_iov = &parts_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }
  // The number of datagrams; negative with errno set.
  int receive(int socket, std::size_t limit) noexcept {
    for (std::size_t i = 0; i < limit; ++i) {
      messages_[i].msg_hdr.msg_control = control_[i].bytes.data();
      messages_[i].msg_hdr.msg_controllen = control_[i].bytes.size();
    }
    return recvmmsg(socket, messages_.data(), static_cast<unsigned>(limit), MSG_DONTWAIT, nullptr);
  }
  std::span<const std::byte> datagram(std::size_t i) const noexcept {
    return std::span<const std::byte>(bytes_[i]).first(messages_[i].msg_len);
  }
  bool truncated(std::size_t i) const noexcept { return (messages_[i].msg_hdr.msg_flags & MSG_TRUNC) != 0; }
  // The socket's drops so far, as of datagram i; `otherwise` if the kernel did not say.
  std::uint32_t drops(std::size_t i, std::uint32_t otherwise) noexcept {
    msghdr& header = messages_[i].msg_hdr;
    for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
      if (control->cmsg_level != SOL_SOCKET || control->cmsg_type != SO_RXQ_OVFL) continue;
      std::memcpy(&otherwise, CMSG_DATA(control), sizeof otherwise);
    }
    return otherwise;
  }

 private:
  struct alignas(cmsghdr) Control {
    std::array<std::byte, CMSG_SPACE(sizeof(std::uint32_t))> bytes;
  };
  std::array<std::array<std::byte, kSlotBytes>, kBatch> bytes_{};
  std::array<Control, kBatch> control_{};
  std::array<iovec, kBatch> parts_{};
  std::array<mmsghdr, kBatch> messages_{};
};

std::size_t request_receive_buffer(int socket, std::size_t bytes) {
  const int asked = static_cast<int>(bytes);
  const auto granted = [socket] {
    int value = 0;
    socklen_t size = sizeof value;
    getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &value, &size);
    return static_cast<std::size_t>(value) / 2;  // the kernel doubles it, for its own bookkeeping
  };
  setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &asked, sizeof asked);
  // Beyond net.core.rmem_max only with CAP_NET_ADMIN; without it the smaller buffer stays.
  if (granted() < bytes) setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &asked, sizeof asked);
  return granted();
}

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
      : decoder(options.decoder), socket(bound_socket(io, options)), on_ready(std::move(ready)) {
    port = socket.local_endpoint().port();
    granted_buffer_bytes = request_receive_buffer(socket.native_handle(), options.receive_buffer_bytes);
    const int on = 1;
    setsockopt(socket.native_handle(), SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
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
  ReceiveBatch batch;
  UdpSourceCounters counters;
  std::uint32_t known_drops = 0;
  std::uint16_t port = 0;
  std::size_t granted_buffer_bytes = 0;
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
const UdpSourceCounters& UdpSource::counters() const noexcept { return impl_->counters; }
std::uint16_t UdpSource::port() const noexcept { return impl_->port; }
std::size_t UdpSource::granted_buffer_bytes() const noexcept { return impl_->granted_buffer_bytes; }

}  // namespace risorius
