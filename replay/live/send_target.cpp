#include "replay/live/send_target.h"

#include <charconv>
#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::string_view kUdpScheme = "udp://";
constexpr std::string_view kZmqScheme = "zmq+tcp://";
constexpr const char* kRemedy = "write udp://HOST:PORT or zmq+tcp://HOST:PORT, such as udp://127.0.0.1:7000";

SendTarget parse(std::string_view url, std::uint16_t lowest_port) {
  const auto fail = [url](const char* problem) { return UserError(fmt::format("\"{}\"", url), problem, kRemedy); };
  SendTarget target;
  std::string_view rest = url;
  if (rest.starts_with(kUdpScheme)) {
    rest.remove_prefix(kUdpScheme.size());
  } else if (rest.starts_with(kZmqScheme)) {
    target.transport = Transport::kZmqPush;
    rest.remove_prefix(kZmqScheme.size());
  } else {
    throw fail("it starts with neither udp:// nor zmq+tcp://");
  }
  const auto colon = rest.rfind(':');
  if (colon == std::string_view::npos || rest.ends_with(']')) throw fail("it has no port");
  std::string_view host = rest.substr(0, colon);
  const std::string_view port = rest.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    throw fail("an IPv6 address must stand in brackets");
  }
  if (host.empty()) throw fail("it has no host");
  if (host.find_first_of("/[]@ ") != std::string_view::npos)
    throw fail("the host has a character that no host can have");
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), target.port);
  if (error != std::errc() || end != port.data() + port.size() || target.port < lowest_port) {
    throw fail(lowest_port == 0 ? "the port is no number from 0 to 65535" : "the port is no number from 1 to 65535");
  }
  target.host = host;
  return target;
}

}  // namespace

SendTarget parse_send_target(std::string_view url) { return parse(url, 1); }

SendTarget parse_listen_address(std::string_view url) { return parse(url, 0); }

std::string to_url(const SendTarget& target) {
  const std::string_view scheme = target.transport == Transport::kUdp ? kUdpScheme : kZmqScheme;
  const bool ipv6 = target.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}{}:{}", scheme, ipv6 ? "[" : "", target.host, ipv6 ? "]" : "", target.port);
}

double default_frame_cap_hz(Transport transport) noexcept { return transport == Transport::kUdp ? 4000 : 0; }

}  // namespace risorius
