// Plain POSIX sending to a loopback port, and running an io_context until something has come: for tests of real
// sockets.
#pragma once

#include <arpa/inet.h>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <span>
#include <sys/socket.h>
#include <unistd.h>

namespace risorius::test {

class LoopbackUdp {
 public:
  explicit LoopbackUdp(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) ADD_FAILURE() << "cannot connect";
  }
  ~LoopbackUdp() { ::close(socket_); }
  LoopbackUdp(const LoopbackUdp&) = delete;
  LoopbackUdp& operator=(const LoopbackUdp&) = delete;
  /// When this returns, the datagram lies in the receiver's buffer, or was dropped by the kernel.
  bool send(std::span<const std::byte> datagram) {
    return ::send(socket_, datagram.data(), datagram.size(), 0) == static_cast<ssize_t>(datagram.size());
  }

 private:
  int socket_;
};

/// Runs handlers until done() holds. False if nothing at all happened for 30 s: that is a failure, not a measurement.
template <class Done>
bool run_until(boost::asio::io_context& io, Done done) {
  while (!done()) {
    io.restart();
    if (io.run_one_for(std::chrono::seconds(30)) == 0) return false;
  }
  return true;
}

}  // namespace risorius::test
