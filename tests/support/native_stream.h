// Marker sets, frames and their datagrams, as the tests of the native protocol need them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/wire/marker_codec.h"

namespace risorius::test {

using Bytes = std::vector<std::byte>;

inline MarkerSet marker_set(std::size_t count, std::uint32_t id = 1, const std::string& prefix = "marker") {
  MarkerSet set{.id = id, .names = {}, .rate_hz = 100};
  for (std::size_t i = 0; i < count; ++i) set.names.push_back(prefix + std::to_string(i));
  return set;
}

/// A frame at 100 Hz with every seventh marker missing and positions that no two markers or frames share.
inline MarkerFrame marker_frame(std::uint64_t sequence, std::size_t count, std::uint32_t set_id = 1) {
  MarkerFrame frame;
  frame.header.set_id = set_id;
  frame.header.sequence = sequence;
  frame.header.capture_time_ns = static_cast<std::int64_t>(sequence) * 10'000'000;
  frame.count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    if ((sequence + i) % 7 == 0) continue;
    const auto base = static_cast<float>(sequence) + static_cast<float>(i) / 3;
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] = {base, -base, std::sqrt(base)};
  }
  return frame;
}

inline std::vector<Bytes> datagrams_of(const MarkerSet& set, std::uint32_t session = 1, std::uint16_t revision = 0) {
  std::vector<Bytes> datagrams;
  DatagramBuffer buffer;
  for (std::size_t next = 0; next < set.names.size();) {
    const EncodedPart part = encode(set, session, revision, next, buffer);
    datagrams.emplace_back(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(part.bytes));
    next = part.next;
  }
  return datagrams;
}

inline std::vector<Bytes> datagrams_of(const MarkerFrame& frame, std::uint32_t session = 1) {
  std::vector<Bytes> datagrams;
  DatagramBuffer buffer;
  for (std::size_t next = 0; next < frame.count;) {
    const EncodedPart part = encode(frame, session, next, buffer);
    datagrams.emplace_back(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(part.bytes));
    next = part.next;
  }
  return datagrams;
}

inline Bytes datagram_of(const EndOfStream& end) {
  DatagramBuffer buffer;
  const std::size_t size = encode(end, buffer);
  return Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size));
}

/// Equal in all that travels on the wire.
inline bool same_markers(const MarkerFrame& a, const MarkerFrame& b) {
  return a.header.set_id == b.header.set_id && a.header.sequence == b.header.sequence &&
         a.header.capture_time_ns == b.header.capture_time_ns && a.count == b.count && a.state == b.state &&
         a.position_mm == b.position_mm;
}

}  // namespace risorius::test
