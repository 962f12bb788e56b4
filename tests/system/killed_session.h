// A daemon that is killed while it records, and what is left of its session: shared by the test and ./run bench kill.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace risorius::test {

struct KilledSession {
  std::string problem;                 ///< why nothing could be measured, or what did not fit; empty if all did
  double lost_s = 0;                   ///< from the last Tick in the file to the kill
  std::uint64_t frames = 0;            ///< whose Ticks are in the recovered file
  std::uint64_t corrupted_frames = 0;  ///< of these, not bit for bit what the performer sent, or missing between others
  std::uint64_t solved_equal = 0, solved_different = 0;  ///< AUs and continuations, solved again
};

/// Streams the built-in performer into a recording daemon, kills it with SIGKILL `seconds` after frames came in,
/// recovers the file and compares it with what was sent.
KilledSession record_and_kill(const std::filesystem::path& folder, double seconds);

}  // namespace risorius::test
