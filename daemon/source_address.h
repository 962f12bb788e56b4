// What `listen` of a [[source]] means: SCHEME://HOST:PORT. One table knows the schemes; a scheme with a port of its own
// may leave it out.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace risorius {

enum class SourceKind : std::uint8_t { kUdp, kZmq, kNatnet, kQtm, kVicon, kLiveLink };

struct SourceAddress {
  SourceKind kind = SourceKind::kUdp;
  std::string host;  ///< name or address, without brackets
  std::uint16_t port = 0;
};

/// Throws UserError naming the text and what it should look like.
SourceAddress parse_source_address(std::string_view url);

/// "natnet://" and so on.
std::string_view scheme_of(SourceKind kind) noexcept;

/// As parse_source_address reads it.
std::string to_url(const SourceAddress& address);

}  // namespace risorius
