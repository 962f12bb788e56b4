// The clock of receive times and pacing. For sources and senders at the edge; stages have no clock.
#pragma once

#include <cstdint>
#include <ctime>

namespace risorius {

/// CLOCK_MONOTONIC in ns.
inline std::int64_t monotonic_now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// UTC in ns since 1970; for the one clock pair of a session.
inline std::int64_t utc_now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace risorius
