// A TCP connection to a tracker that is always wanted: connects without blocking, reads into a bounded buffer, writes
// from a bounded queue, and when the connection fails makes it anew, after 0.25 s at first and 5 s at most. Lives on
// the thread that runs the io_context.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "capture/counters.h"

namespace boost::asio {
class io_context;
}

namespace risorius {

struct TcpLinkOptions {
  std::string host;
  std::uint16_t port = 0;
  std::size_t read_buffer_bytes = 1 << 20;     ///< at least as long as the longest packet
  std::size_t write_queue_bytes = 1 << 16;     ///< more than this unsent: the connection is given up
  std::size_t receive_buffer_bytes = 1 << 20;  ///< asked of the kernel
  std::int64_t connect_timeout_ns = 3'000'000'000;
  std::int64_t first_wait_ns = 250'000'000;  ///< after a failure; doubles with each
  std::int64_t longest_wait_ns = 5'000'000'000;
};

struct TcpLinkCounters {
  Counter connections;  ///< that were made
  Counter failures;     ///< to connect, or of a connection
  Counter wake_ups;
  Counter granted_buffer_bytes;  ///< of the connection's receive buffer
};

class TcpLink {
 public:
  struct Handlers {
    std::function<void()> connected;
    /// Bytes as they lie in the buffer, and CLOCK_MONOTONIC right after the receive call. Returns how many were used;
    /// the rest is offered again in front of what comes next. If none are used of a full buffer, the link pauses;
    /// nullopt: there is no room for anything, all is offered again after round_done or resume().
    std::function<std::optional<std::size_t>(std::span<const std::byte>, std::int64_t)> received;
    /// After a round of receiving: the consumer may pop. Returns false to pause until resume().
    std::function<bool()> round_done;
    std::function<void()> lost;
  };

  TcpLink(boost::asio::io_context& io, const TcpLinkOptions& options, Handlers handlers);
  ~TcpLink();
  TcpLink(const TcpLink&) = delete;
  TcpLink& operator=(const TcpLink&) = delete;

  void start();
  /// No handler is called any more. Final.
  void stop() noexcept;
  /// After a pause: offers what lies in the buffer and reads on.
  void resume();
  /// Gives the connection up and makes another; `lost` is called from the io_context.
  void drop();
  /// The connection works: the next failure is followed by the short wait.
  void healthy() noexcept;
  void send(std::span<const std::byte> bytes);

  bool connected() const noexcept;
  /// Of the connection, as numbers; "" without one.
  std::string local_address() const;
  std::string peer_address() const;
  const TcpLinkCounters& counters() const noexcept;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handlers that wait in the io_context
};

}  // namespace risorius
