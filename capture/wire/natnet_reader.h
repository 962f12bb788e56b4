// Reading NatNet's counts, strings and sections, for the decoders. An error stays: a decoder reads straight through and
// asks once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "capture/wire/byte_io.h"
#include "capture/wire/natnet_codec.h"

namespace risorius {

class NatnetReader {
 public:
  static constexpr std::size_t kMaxStringBytes = 255;

  explicit NatnetReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes), reader_(bytes) {}

  template <class T>
  T read() noexcept {
    return reader_.read<T>();
  }
  std::span<const std::byte> take(std::size_t size) noexcept { return reader_.take(size); }
  /// `count` records of `size` bytes.
  std::span<const std::byte> take(std::uint32_t count, std::size_t size) noexcept {
    return reader_.take(std::size_t{count} * size);
  }
  /// A number of things of at least `least_bytes` each; 0 after an error.
  std::uint32_t count(std::size_t least_bytes) noexcept {
    const auto value = reader_.read<std::int32_t>();
    if (value < 0) negative_ = true;
    if (value < 0 || std::size_t(value) * least_bytes > reader_.remaining()) fail();
    return ok() ? static_cast<std::uint32_t>(value) : 0;
  }
  /// Up to its NUL, which is taken as well.
  std::string_view string() noexcept {
    const auto rest = rest_bytes();
    const auto window = rest.first(std::min(rest.size(), kMaxStringBytes + 1));
    const auto nul = std::find(window.begin(), window.end(), std::byte{0});
    if (nul == window.end()) {
      fail();
      return {};
    }
    const auto size = static_cast<std::size_t>(nul - window.begin());
    const auto text = reader_.take(size + 1);
    return {reinterpret_cast<const char*>(text.data()), text.empty() ? 0 : size};
  }
  void fail() noexcept {
    failed_ = true;
    reader_.take(reader_.remaining() + 1);
  }
  std::size_t remaining() const noexcept { return reader_.remaining(); }
  std::size_t position() const noexcept { return bytes_.size() - reader_.remaining(); }
  std::span<const std::byte> rest_bytes() const noexcept { return bytes_.last(reader_.remaining()); }
  bool ok() const noexcept { return !failed_ && reader_.ok(); }
  NatnetError error() const noexcept {
    if (ok()) return NatnetError::kNone;
    return negative_ ? NatnetError::kBadCount : NatnetError::kTruncated;
  }

 private:
  std::span<const std::byte> bytes_;
  ByteReader reader_;
  bool failed_ = false, negative_ = false;
};

}  // namespace risorius
