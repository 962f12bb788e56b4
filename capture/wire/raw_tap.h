// Where a recorder listens to what a source receives: the bytes as they came, and whether anybody could use them. A
// source without a tap pays for one comparison per datagram.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <sys/socket.h>

namespace risorius {

/// Who sent it.
struct RawOrigin {
  std::uint8_t ip_version = 0;  ///< 4 or 6; 0: the transport does not say
  std::uint16_t port = 0;
  std::array<std::uint8_t, 16> address{};
  friend bool operator==(const RawOrigin&, const RawOrigin&) = default;
};

RawOrigin raw_origin_of(const sockaddr_storage& sender) noexcept;
/// "127.0.0.1:7000", "[::1]:7000"; empty if it is not known.
std::string text_of(const RawOrigin& origin);

/// `bytes` are the source's; valid during the call.
struct RawMessage {
  std::span<const std::byte> bytes;
  RawOrigin origin;
  std::int64_t receive_time_ns = 0;
  bool is_refused = false;  ///< by the decoder, or because it comes from another host than the tracker
};

class RawTap {
 public:
  /// Called on the source's thread. Must not block: it stands in the way of a frame.
  using Receive = void (*)(void* context, std::uint32_t stream_id, const RawMessage& message) noexcept;

  RawTap() = default;
  RawTap(Receive receive, void* context, std::uint32_t stream_id) noexcept
      : receive_(receive), context_(context), stream_id_(stream_id) {}

  explicit operator bool() const noexcept { return receive_ != nullptr; }
  void operator()(const RawMessage& message) const noexcept {
    if (receive_ != nullptr) receive_(context_, stream_id_, message);
  }
  void operator()(std::span<const std::byte> bytes, const sockaddr_storage& sender, std::int64_t receive_time_ns,
                  bool is_refused) const noexcept {
    if (receive_ != nullptr)
      receive_(context_, stream_id_, {bytes, raw_origin_of(sender), receive_time_ns, is_refused});
  }

 private:
  Receive receive_ = nullptr;
  void* context_ = nullptr;
  std::uint32_t stream_id_ = 0;
};

}  // namespace risorius
