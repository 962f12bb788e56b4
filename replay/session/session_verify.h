// A session solved again: the recorded Ticks with the recorded configuration and rig, compared byte for byte with the
// AUs and continuations that were published and recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace risorius {

/// Of one kind of message of one stream.
struct VerifiedTopic {
  std::string topic;
  std::uint64_t equal = 0, different = 0;
  /// Solved, but not in the file: lost, or behind its end.
  std::uint64_t not_recorded = 0;
  /// Recorded, but no Tick gives them: Ticks are missing.
  std::uint64_t not_solved = 0;
  std::optional<std::uint64_t> first_different_sequence;  ///< the tracker's
};

struct SessionVerdict {
  std::vector<VerifiedTopic> topics;
  std::uint64_t ticks = 0, missing_ticks = 0;
  bool whole = false;        ///< the file has its end, and no damage
  std::string recovered_of;  ///< the torn file that this one was recovered from; empty if it was not
  /// What that file lacked, in the words of the recovery.
  std::vector<std::string> missing_in_recovered;
  std::vector<std::string> notes;  ///< what may make them differ: another program, another instruction set

  std::uint64_t different() const noexcept;
  std::uint64_t equal() const noexcept;
  std::uint64_t not_solved() const noexcept;
};

/// Called now and then with bytes read and the file's.
using SessionProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;

/// Throws UserError if the file is no session, or what it holds cannot be solved.
SessionVerdict verify_session(const std::filesystem::path& path, const SessionProgress& progress);

}  // namespace risorius
