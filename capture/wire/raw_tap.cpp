#include "capture/wire/raw_tap.h"

#include <arpa/inet.h>
#include <cstring>
#include <fmt/format.h>
#include <netinet/in.h>

namespace risorius {

RawOrigin raw_origin_of(const sockaddr_storage& sender) noexcept {
  RawOrigin origin;
  if (sender.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(sender);
    origin.ip_version = 4;
    origin.port = ntohs(v4.sin_port);
    std::memcpy(origin.address.data(), &v4.sin_addr, sizeof v4.sin_addr);
  } else if (sender.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(sender);
    origin.ip_version = 6;
    origin.port = ntohs(v6.sin6_port);
    std::memcpy(origin.address.data(), &v6.sin6_addr, sizeof v6.sin6_addr);
  }
  return origin;
}

std::string text_of(const RawOrigin& origin) {
  if (origin.ip_version != 4 && origin.ip_version != 6) return {};
  char text[INET6_ADDRSTRLEN] = "";
  inet_ntop(origin.ip_version == 4 ? AF_INET : AF_INET6, origin.address.data(), text, sizeof text);
  return origin.ip_version == 4 ? fmt::format("{}:{}", text, origin.port) : fmt::format("[{}]:{}", text, origin.port);
}

}  // namespace risorius
