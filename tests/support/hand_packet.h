// Packets written by hand, value by value, for tests that must not trust the project's own encoders.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace risorius::test {

class HandPacket {
 public:
  template <class T>
  HandPacket& put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
    return *this;
  }
  HandPacket& u8(unsigned value) { return put(static_cast<std::uint8_t>(value)); }
  HandPacket& i16(int value) { return put(static_cast<std::int16_t>(value)); }
  HandPacket& u16(unsigned value) { return put(static_cast<std::uint16_t>(value)); }
  HandPacket& i32(std::int64_t value) { return put(static_cast<std::int32_t>(value)); }
  HandPacket& u32(std::uint64_t value) { return put(static_cast<std::uint32_t>(value)); }
  HandPacket& u64(std::uint64_t value) { return put(value); }
  HandPacket& f32(std::initializer_list<float> values) {
    for (const float value : values) put(value);
    return *this;
  }
  HandPacket& f64(double value) { return put(value); }
  /// With its NUL.
  HandPacket& text(std::string_view value) {
    for (const char c : value) put(c);
    return u8(0);
  }
  HandPacket& zeros(std::size_t count) {
    bytes_.resize(bytes_.size() + count);
    return *this;
  }
  HandPacket& packet(const HandPacket& other) {
    bytes_.insert(bytes_.end(), other.bytes_.begin(), other.bytes_.end());
    return *this;
  }
  const std::vector<std::byte>& bytes() const noexcept { return bytes_; }
  std::size_t size() const noexcept { return bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace risorius::test
