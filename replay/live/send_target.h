// Where a sender sends to: "udp://HOST:PORT" or "zmq+tcp://HOST:PORT"; an IPv6 address stands in brackets.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace risorius {

enum class Transport : std::uint8_t { kUdp, kZmqPush };

struct SendTarget {
  Transport transport = Transport::kUdp;
  std::string host;  ///< name or address, without brackets
  std::uint16_t port = 0;
};

/// Throws UserError naming the text and what it should look like.
SendTarget parse_send_target(std::string_view url);

/// The same for the receiving side, where port 0 lets the system choose.
SendTarget parse_listen_address(std::string_view url);

/// As parse_send_target reads it.
std::string to_url(const SendTarget& target);

/// Frames per second for a sender without pacing. UDP does not slow a sender down when the receiver is behind, so a
/// sender must not be much faster than a pipeline can be; ZeroMQ does: 0, no cap.
double default_frame_cap_hz(Transport transport) noexcept;

}  // namespace risorius
