// Receives the native protocol over UDP: datagrams of one socket -> events of one MarkerStreamDecoder.
// Lives on the thread that runs the io_context. Drains the socket in bounded batches and then calls `on_ready` once,
// which should pop the decoder until it has no more. If it leaves the decoder full, the source pauses until resume():
// what comes meanwhile waits in the kernel's buffer, and what does not fit there is counted as kernel_drops. Nothing
// allocates per frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "capture/counters.h"
#include "capture/wire/marker_stream_decoder.h"

namespace boost::asio {
class io_context;
}

namespace risorius {

struct UdpSourceOptions {
  std::string address = "127.0.0.1";  ///< of the interface to listen on, IPv4 or IPv6
  std::uint16_t port = 7000;          ///< 0: the system chooses
  std::size_t receive_buffer_bytes =
      8 * 1024 * 1024;  ///< asked of the kernel, 1 KiB to 1 GiB; see granted_buffer_bytes
  DecoderOptions decoder;
};

struct UdpSourceCounters {
  Counter kernel_drops;  ///< datagrams that found the receive buffer full (SO_RXQ_OVFL), known with the next datagram
  Counter truncated;     ///< longer than any native message by far; refused by the decoder as too_long
  Counter wake_ups;
  Counter pauses;          ///< the consumer left the decoder full
  Counter receive_errors;  ///< of the socket
};

class UdpSource {
 public:
  /// Binds. Throws UserError naming address:port or the option, and the remedy.
  UdpSource(boost::asio::io_context& io, const UdpSourceOptions& options, std::function<void()> on_ready);
  ~UdpSource();
  UdpSource(const UdpSource&) = delete;
  UdpSource& operator=(const UdpSource&) = delete;

  void start();
  /// Closes the socket; on_ready is not called any more. Final.
  void stop() noexcept;
  /// After a pause: there is room in the decoder again.
  void resume();

  MarkerStreamDecoder& decoder() noexcept;
  const UdpSourceCounters& counters() const noexcept;
  std::uint16_t port() const noexcept;
  /// What the kernel gave, in the terms of receive_buffer_bytes. Below it where net.core.rmem_max forbids more.
  std::size_t granted_buffer_bytes() const noexcept;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handler that waits in the io_context
};

}  // namespace risorius
