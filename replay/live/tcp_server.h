// The TCP side of a TrackerServer: accepts clients, reads what they say, and writes to each from a bounded queue of its
// own, so that one that does not read loses frames and holds nobody up. Lives on the thread that runs the io_context.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace boost::asio {
class io_context;
}

namespace risorius {

struct TcpServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;                   ///< 0: the system chooses
  std::size_t most_clients = 32;            ///< more are closed at once
  std::size_t read_buffer_bytes = 1 << 16;  ///< a request that does not fit costs the connection
  std::size_t queue_bytes = 1 << 18;        ///< unsent bytes of a client beyond which it gets no frames
};

class TcpServer {
 public:
  using ClientId = std::uint64_t;
  struct Handlers {
    std::function<void(ClientId)> joined;
    /// How many bytes of the front were used; the rest comes again with more. Empty: the client is to be closed.
    std::function<std::optional<std::size_t>(ClientId, std::span<const std::byte>)> received;
    std::function<void(ClientId)> left;
  };

  /// Binds. Throws UserError naming `scheme`://address:port and the remedy.
  TcpServer(boost::asio::io_context& io, const std::string& scheme, const TcpServerOptions& options, Handlers handlers);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  /// Begins to accept.
  void start();
  /// Writes what is queued for at most half a second in all, and closes every connection. Final.
  void finish() noexcept;

  /// An answer. A client that lets answers pile up is closed.
  void send(ClientId client, std::span<const std::byte> bytes);
  /// All of a frame or nothing: false if the client's queue is full or it has gone.
  bool send_frame(ClientId client, std::span<const std::byte> bytes);
  /// After what is queued has been sent, as far as that goes at once.
  void close(ClientId client);

  std::uint16_t port() const noexcept;
  /// Of the client, as numbers; "" if it has gone.
  std::string peer_address(ClientId client) const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handlers that wait in the io_context
};

}  // namespace risorius
