// Growing little-endian packets: values are appended, and a length that stands before what it counts is filled in
// afterwards. For messages whose size nobody knows beforehand; keeps its memory when cleared.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace risorius {

static_assert(std::endian::native == std::endian::little, "byte_appender.h copies values as they lie in memory");

class ByteAppender {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void append(T value) { append_bytes(std::as_bytes(std::span<const T, 1>(&value, 1))); }
  void append_bytes(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void append_text(std::string_view text) { append_bytes(std::as_bytes(std::span(text.data(), text.size()))); }

  /// Overwrites the u32 at `offset`, which was appended before.
  void patch(std::size_t offset, std::uint32_t value) noexcept {
    std::memcpy(bytes_.data() + offset, &value, sizeof value);
  }
  std::size_t size() const noexcept { return bytes_.size(); }
  std::span<const std::byte> bytes() const noexcept { return bytes_; }
  void clear() noexcept { bytes_.clear(); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace risorius
