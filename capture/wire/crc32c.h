// CRC-32C (Castagnoli), as in iSCSI (RFC 3720, appendix B.4), SSE4.2 and Python's `crc32c` package.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace risorius {

/// The checksum of `bytes`. To go on over further bytes, hand in the checksum of those before them.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0) noexcept;

}  // namespace risorius
