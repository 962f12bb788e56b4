// Rough treatment of a real daemon, measured: senders that are killed, clocks that jump. Each starts a daemon
// of its own and throws std::runtime_error if it does not come up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace risorius::test {

struct RestartRun {
  std::vector<double> resume_ms;  ///< of each restart: from the new sender's first datagram to its first frame solved
  std::size_t descriptors_before = 0, descriptors_after = 0;
  double resident_growth_bytes = 0;          ///< over all restarts
  double settled_resident_growth_bytes = 0;  ///< after a quarter of them, when every allocator has seen what it will
  std::uint64_t sessions = 0;
};
/// A sender (a process, 120 Hz x 60 markers) is killed with SIGKILL in the midst of its stream and another one started,
/// `times` times.
RestartRun kill_and_restart_sender(std::size_t times);

struct ClockJumpRun {
  std::uint64_t sent = 0, processed = 0;
  std::uint64_t gone = 0;   ///< lost, late, dropped or refused
  std::uint64_t jumps = 0;  ///< of the tracker's clock
  std::uint64_t leaps = 0;  ///< that the daemon noticed
};
/// 240 Hz; the capture times leap an hour ahead, two hours back, a minute ahead, a second back; `frames` after each.
ClockJumpRun jump_tracker_clock(std::uint64_t frames);

}  // namespace risorius::test
