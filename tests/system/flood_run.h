// A flood of garbage on one source of a real daemon, and what another source's stream notices of it.
#pragma once

#include <cstdint>

namespace risorius::test {

struct FloodRun {
  double quiet_p99_ms = 0, flooded_p99_ms = 0;  ///< sending to the client's receiving, of the other stream
  double quiet_p50_ms = 0, flooded_p50_ms = 0;
  std::uint64_t unanswered = 0;       ///< frames of the other stream without an answer within 100 ms
  std::uint64_t lost = 0;             ///< of the other stream, by the daemon's counters, the kernel's included
  std::uint64_t flood_sent = 0;       ///< datagrams of garbage
  std::uint64_t flood_accounted = 0;  ///< of these received or dropped by the kernel, as the daemon counts
  double flood_rate_hz = 0;
  double resident_growth_bytes = 0;
};
/// 240 Hz x 60 markers on one source; on another, every second block of time, garbage as fast as one thread can send
/// it. `blocks` of each kind, `seconds` long.
FloodRun flood_beside_a_stream(int blocks, double seconds);

}  // namespace risorius::test
