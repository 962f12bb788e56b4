#include "daemon/source_address.h"

#include <array>
#include <charconv>
#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {
namespace {

struct Scheme {
  SourceKind kind;
  std::string_view text;
  std::uint16_t default_port;  ///< 0: the port must be given
  std::uint16_t lowest_port;   ///< 0: the system may choose
};

constexpr std::array kSchemes{
    Scheme{SourceKind::kUdp, "udp://", 0, 0},          Scheme{SourceKind::kZmq, "zmq+tcp://", 0, 0},
    Scheme{SourceKind::kNatnet, "natnet://", 1510, 1}, Scheme{SourceKind::kQtm, "qtm://", 22223, 1},
    Scheme{SourceKind::kVicon, "vicon://", 801, 1},    Scheme{SourceKind::kLiveLink, "livelink://", 11111, 0}};
constexpr const char* kRemedy =
    "write udp://ADDRESS:PORT, zmq+tcp://ADDRESS:PORT or livelink://ADDRESS to listen on, or natnet://HOST, "
    "qtm://HOST, "
    "vicon://HOST to connect to";

const Scheme& scheme_of(std::string_view url) {
  for (const Scheme& scheme : kSchemes) {
    if (url.starts_with(scheme.text)) return scheme;
  }
  throw UserError(fmt::format("\"{}\"", url),
                  "it starts with none of udp:// zmq+tcp:// natnet:// qtm:// vicon:// livelink://", kRemedy);
}

}  // namespace

std::string_view scheme_of(SourceKind kind) noexcept {
  for (const Scheme& scheme : kSchemes) {
    if (scheme.kind == kind) return scheme.text;
  }
  return {};
}

SourceAddress parse_source_address(std::string_view url) {
  const Scheme& scheme = scheme_of(url);
  const auto fail = [url](const std::string& problem) {
    return UserError(fmt::format("\"{}\"", url), problem, kRemedy);
  };
  std::string_view host = url.substr(scheme.text.size());
  SourceAddress address{.kind = scheme.kind, .port = scheme.default_port};
  const auto colon = host.rfind(':');
  const bool bracketed_alone = host.starts_with('[') && host.ends_with(']');
  if (colon != std::string_view::npos && !bracketed_alone) {
    const std::string_view port = host.substr(colon + 1);
    host = host.substr(0, colon);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    if (error != std::errc() || end != port.data() + port.size() || address.port < scheme.lowest_port) {
      throw fail(fmt::format("the port is no number from {} to 65535", scheme.lowest_port));
    }
  } else if (scheme.default_port == 0) {
    throw fail("it has no port");
  }
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    throw fail("an IPv6 address must stand in brackets");
  }
  if (host.empty()) throw fail("it has no host");
  if (host.find_first_of("/[]@ ") != std::string_view::npos)
    throw fail("the host has a character that no host can have");
  address.host = host;
  return address;
}

std::string to_url(const SourceAddress& address) {
  const bool ipv6 = address.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}{}:{}", scheme_of(address.kind), ipv6 ? "[" : "", address.host, ipv6 ? "]" : "",
                     address.port);
}

}  // namespace risorius
