// Numbers as the three processor families of C3D stored them: Intel (little-endian IEEE), DEC (VAX: little-endian
// integers, F_floating) and MIPS (big-endian IEEE). Pure functions over bytes; the caller checks lengths.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace risorius {

/// Byte 4 of the parameter section.
enum class C3dProcessor : std::uint8_t { kIntel = 84, kDec = 85, kMips = 86 };

inline constexpr std::size_t kC3dBlockBytes = 512;

inline std::uint16_t c3d_word(const std::uint8_t* bytes, C3dProcessor processor) noexcept {
  const unsigned low = processor == C3dProcessor::kMips ? bytes[1] : bytes[0];
  const unsigned high = processor == C3dProcessor::kMips ? bytes[0] : bytes[1];
  return static_cast<std::uint16_t>(low | (high << 8));
}

inline std::int16_t c3d_integer(const std::uint8_t* bytes, C3dProcessor processor) noexcept {
  return static_cast<std::int16_t>(c3d_word(bytes, processor));
}

/// VAX F_floating: the 16-bit word with sign and exponent comes first; value = 0.1mmm... x 2^(exponent - 128).
inline float c3d_vax_float(std::uint32_t bits) noexcept {
  constexpr int kExponentBias = 128, kMantissaBits = 24;
  const int exponent = static_cast<int>((bits >> 23) & 0xFF);
  const bool negative = (bits >> 31) != 0;
  // A zero exponent is zero; with the sign set it is VAX's "reserved operand".
  if (exponent == 0) return negative ? std::numeric_limits<float>::quiet_NaN() : 0.0f;
  const auto mantissa = static_cast<float>((bits & 0x7FFFFFu) | 0x800000u);
  return std::ldexp(negative ? -mantissa : mantissa, exponent - kExponentBias - kMantissaBits);
}

inline float c3d_float(const std::uint8_t* bytes, C3dProcessor processor) noexcept {
  const std::uint32_t first = c3d_word(bytes, processor), second = c3d_word(bytes + 2, processor);
  if (processor == C3dProcessor::kIntel) return std::bit_cast<float>((second << 16) | first);
  const std::uint32_t bits = (first << 16) | second;
  return processor == C3dProcessor::kMips ? std::bit_cast<float>(bits) : c3d_vax_float(bits);
}

}  // namespace risorius
