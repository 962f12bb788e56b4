// Live Link Face packets written by hand, byte by byte: tests of the codec must not trust the encoder.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace risorius::test {

struct HandLiveLink {
  bool one_byte_version = false;
  std::string id = "$01234567-89AB-CDEF-0123-456789ABCDEF";
  std::string name = "iPhone";
  std::int32_t frame = 100;
  float subframe = 0.25F;
  std::int32_t fps = 60, denominator = 1;
  bool has_count = true;
  std::vector<float> values = ramp(61);

  /// i / 64: exact in a float.
  static std::vector<float> ramp(std::size_t count) {
    std::vector<float> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(i) / 64);
    return values;
  }

  std::vector<std::byte> bytes() const {
    std::vector<std::byte> out;
    const auto byte = [&](unsigned value) { out.push_back(static_cast<std::byte>(value)); };
    const auto big = [&](std::uint32_t value) {
      for (const int shift : {24, 16, 8, 0}) byte(value >> shift & 0xFF);
    };
    const auto text = [&](std::string_view words) {
      for (const char c : words) byte(static_cast<unsigned char>(c));
    };
    byte(6);
    for (int i = 0; i < 3 && !one_byte_version; ++i) byte(0);
    text(id);
    big(static_cast<std::uint32_t>(name.size()));
    text(name);
    big(static_cast<std::uint32_t>(frame));
    big(std::bit_cast<std::uint32_t>(subframe));
    big(static_cast<std::uint32_t>(fps));
    big(static_cast<std::uint32_t>(denominator));
    if (!has_count) return out;
    byte(static_cast<unsigned>(values.size()));
    for (const float value : values) big(std::bit_cast<std::uint32_t>(value));
    return out;
  }
};

}  // namespace risorius::test
