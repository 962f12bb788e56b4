// A small face for the tests of NatNet's two sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <string>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "replay/live/tracker_server.h"

namespace risorius::test {

inline MarkerSet face(std::size_t count = 3, double rate_hz = 120) {
  MarkerSet set{.rate_hz = rate_hz};
  for (std::size_t i = 0; i < count; ++i) set.names.push_back(fmt::format("m{}", i));
  return set;
}

/// Positions are multiples of 1/16 m: they survive metres in float bit for bit. Every fifth marker is missing.
inline MarkerFrame face_frame(std::uint64_t sequence, std::size_t count = 3) {
  MarkerFrame frame;
  frame.header.sequence = sequence;
  frame.header.capture_time_ns = static_cast<std::int64_t>(sequence) * 1'000'000;
  frame.count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    if ((sequence + i) % 5 == 4) continue;
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] = {62.5f * static_cast<float>(i + 1), -125, 62.5f * static_cast<float>(sequence % 16)};
  }
  return frame;
}

inline std::uint16_t port_of(const TrackerServer& server) {
  const std::string endpoint = server.endpoint();
  return static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
}

}  // namespace risorius::test
