// Bounded reading and writing of little-endian values, for packet codecs.
// A read or write past the end changes nothing but `ok`, which stays false from then on; so a codec reads straight
// through and asks once.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace risorius {

static_assert(std::endian::native == std::endian::little, "byte_io.h copies values as they lie in memory");

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) noexcept : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T read()
  noexcept {
    T value{};
    const auto bytes = take(sizeof(T));
    if (!bytes.empty()) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  /// The next `size` bytes; empty and not ok if there are fewer.
  std::span<const std::byte> take(std::size_t size) noexcept {
    if (!ok_ || size > rest_.size()) {
      ok_ = false;
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  std::size_t remaining() const noexcept { return rest_.size(); }
  bool ok() const noexcept { return ok_; }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> bytes) noexcept : bytes_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T>
  void write(T value) noexcept { write_bytes(std::as_bytes(std::span<const T, 1>(&value, 1))); }
  void write_bytes(std::span<const std::byte> bytes) noexcept {
    if (!ok_ || bytes.size() > remaining()) {
      ok_ = false;
      return;
    }
    if (!bytes.empty()) std::memcpy(bytes_.data() + size_, bytes.data(), bytes.size());
    size_ += bytes.size();
  }
  std::span<const std::byte> written() const noexcept { return bytes_.first(size_); }
  std::size_t size() const noexcept { return size_; }
  std::size_t remaining() const noexcept { return bytes_.size() - size_; }
  bool ok() const noexcept { return ok_; }

 private:
  std::span<std::byte> bytes_;
  std::size_t size_ = 0;
  bool ok_ = true;
};

}  // namespace risorius
