// Makes a whole file of a torn or damaged one: every message of every chunk whose CRC fits, as it was, in their order,
// with an end and an index; and an account of what is missing, which the new file holds as metadata, too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/session/session_reader.h"

namespace risorius {

struct RecoveredSession {
  std::uint64_t messages = 0;
  std::vector<McapDamage> damages;             ///< in the file that was read, the first of them
  std::uint64_t damage_count = 0;              ///< all of them
  std::uint64_t damaged_bytes = 0;             ///< of the file, that could not be read for them
  std::map<std::string, TopicAccount> topics;  ///< with their gaps
  std::int64_t first_ns = 0, last_ns = 0;      ///< of the messages, UTC
  bool was_whole = false;                      ///< it had its end; what is missing was lost in its chunks
};

/// `output` must not exist. Throws UserError, also where there is nothing to recover; an output that was begun is
/// removed.
RecoveredSession recover_session(const std::filesystem::path& input, const std::filesystem::path& output,
                                 const std::function<void(std::uint64_t done, std::uint64_t of)>& progress);

/// What is missing, in words with UTC times, a line each; empty if nothing is. Of very many damages or gaps the first,
/// and how many there are.
std::vector<std::string> missing_times(const RecoveredSession& session);

/// From the first to the last message of a file that could be read, UTC.
struct MessageTimes {
  std::int64_t first_ns = 0, last_ns = 0;
};
/// "byte 4711: PROBLEM; it held messages from ... to ...", a line each; of more than are listed their number. What a
/// damaged record says of its times is told only where they lie within those of the messages around it.
std::vector<std::string> damage_lines(std::span<const McapDamage> damages, std::uint64_t count, std::uint64_t bytes,
                                      const std::optional<MessageTimes>& times);
/// "7 messages of TOPIC between ... and ..." or "before ...", a line each; of more than are listed their number.
std::vector<std::string> gap_lines(const std::string& topic, const TopicAccount& account);

/// "2026-01-31 10:20:30.123456 UTC".
std::string utc_text(std::int64_t utc_ns);

}  // namespace risorius
