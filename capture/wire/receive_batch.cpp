#include "capture/wire/receive_batch.h"

#include <cstring>

namespace risorius {

ReceiveBatch::ReceiveBatch(std::size_t datagrams, std::size_t datagram_bytes)
    : datagram_bytes_(datagram_bytes),
      bytes_(datagrams * datagram_bytes),
      control_(datagrams),
      senders_(datagrams),
      parts_(datagrams),
      messages_(datagrams) {
  for (std::size_t i = 0; i < datagrams; ++i) {
    parts_[i] = {.iov_base = bytes_.data() + i * datagram_bytes, .iov_len = datagram_bytes};
    messages_[i].msg_hdr.msg_iov = &parts_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
  }
}

int ReceiveBatch::receive(int socket, std::size_t limit) noexcept {
  for (std::size_t i = 0; i < limit; ++i) {
    messages_[i].msg_hdr.msg_control = control_[i].bytes;
    messages_[i].msg_hdr.msg_controllen = sizeof control_[i].bytes;
    messages_[i].msg_hdr.msg_name = &senders_[i];
    messages_[i].msg_hdr.msg_namelen = sizeof senders_[i];
  }
  return recvmmsg(socket, messages_.data(), static_cast<unsigned>(limit), MSG_DONTWAIT, nullptr);
}

std::span<const std::byte> ReceiveBatch::datagram(std::size_t i) const noexcept {
  return std::span<const std::byte>(bytes_).subspan(i * datagram_bytes_, messages_[i].msg_len);
}

std::uint32_t ReceiveBatch::drops(std::size_t i, std::uint32_t otherwise) noexcept {
  msghdr& header = messages_[i].msg_hdr;
  for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
    if (control->cmsg_level != SOL_SOCKET || control->cmsg_type != SO_RXQ_OVFL) continue;
    std::memcpy(&otherwise, CMSG_DATA(control), sizeof otherwise);
  }
  return otherwise;
}

std::size_t prepare_receive_buffer(int socket, std::size_t bytes) noexcept {
  const int on = 1, asked = static_cast<int>(bytes);
  setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
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

}  // namespace risorius
