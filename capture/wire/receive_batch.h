// Many datagrams with one system call (recvmmsg), each with the kernel's count of those that it had to throw away.
// One thread; allocates in the constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <sys/socket.h>
#include <vector>

namespace risorius {

class ReceiveBatch {
 public:
  /// Room for `datagrams` of up to `datagram_bytes` each; longer ones are truncated.
  ReceiveBatch(std::size_t datagrams, std::size_t datagram_bytes);

  std::size_t capacity() const noexcept { return messages_.size(); }
  /// Takes what waits, at most `limit` <= capacity() datagrams. The number of them; negative with errno set.
  int receive(int socket, std::size_t limit) noexcept;

  std::span<const std::byte> datagram(std::size_t i) const noexcept;
  bool truncated(std::size_t i) const noexcept { return (messages_[i].msg_hdr.msg_flags & MSG_TRUNC) != 0; }
  /// Who sent it.
  const sockaddr_storage& sender(std::size_t i) const noexcept { return senders_[i]; }
  /// The socket's drops so far, modulo 2^32, as of datagram i; `otherwise` if the kernel did not say.
  std::uint32_t drops(std::size_t i, std::uint32_t otherwise) noexcept;

 private:
  struct alignas(cmsghdr) Control {
    std::byte bytes[CMSG_SPACE(sizeof(std::uint32_t))];
  };
  std::size_t datagram_bytes_;
  std::vector<std::byte> bytes_;
  std::vector<Control> control_;
  std::vector<sockaddr_storage> senders_;
  std::vector<iovec> parts_;
  std::vector<mmsghdr> messages_;
};

/// Asks for a receive buffer and for the kernel's count of drops. Returns what was granted, in the terms of `bytes`.
std::size_t prepare_receive_buffer(int socket, std::size_t bytes) noexcept;

}  // namespace risorius
