#include "replay/session/session_recover.h"

#include <algorithm>
#include <ctime>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <utility>

#include "capture/errors.h"
#include "replay/mcap/mcap_writer.h"
#include "replay/unfinished_paths.h"

namespace risorius {
namespace {

constexpr std::int64_t kChunkNs = 500'000'000;
constexpr std::size_t kChunkBytes = 4 << 20;
constexpr std::uint64_t kProgressStride = 256;

/// Copies messages, adding schemas and channels as they come.
class Copy {
 public:
  explicit Copy(const std::filesystem::path& path) : file_(path) {}

  void write(const McapReader& from) {
    McapMessage message = from.message();
    message.channel_id = channel_of(from.channels().at(message.channel_id), from.schemas());
    const bool old = file_.chunk_bytes() > 0 && message.log_time_ns - file_.chunk_start_ns() >= kChunkNs;
    if (old || file_.chunk_bytes() >= kChunkBytes) file_.end_chunk();
    file_.write(message);
  }
  void write(const McapMetadata& metadata) { file_.write_metadata(metadata); }
  void finish() { file_.finish(); }

 private:
  std::uint16_t channel_of(const McapChannel& channel, const std::map<std::uint16_t, McapSchema>& schemas) {
    // An id of a damaged file may have been given twice.
    if (const auto known = channels_.find(channel); known != channels_.end()) return known->second;
    std::uint16_t schema = 0;
    if (const auto found = schemas.find(channel.schema_id); found != schemas.end()) schema = schema_of(found->second);
    const std::uint16_t id = file_.add_channel(schema, channel.topic, channel.message_encoding, channel.metadata);
    channels_.emplace(channel, id);
    return id;
  }
  std::uint16_t schema_of(const McapSchema& schema) {
    if (const auto known = schemas_.find(schema); known != schemas_.end()) return known->second;
    const std::uint16_t id = file_.add_schema(schema.name, schema.encoding, schema.data);
    schemas_.emplace(schema, id);
    return id;
  }

  McapWriter file_;
  std::map<McapChannel, std::uint16_t> channels_;
  std::map<McapSchema, std::uint16_t> schemas_;
};

void copy_all(const std::filesystem::path& input, Copy& copy, RecoveredSession& result,
              const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  McapReader file(input);
  bool has_metadata = false;
  for (auto item = file.next(); item != McapReader::Item::kEnd; item = file.next()) {
    if (item == McapReader::Item::kMetadata) {
      copy.write(file.metadata());
      has_metadata = true;
      continue;
    }
    copy.write(file);
    const std::int64_t time_ns = file.message().log_time_ns;
    result.first_ns = result.messages == 0 ? time_ns : std::min(result.first_ns, time_ns);
    result.last_ns = std::max(result.last_ns, time_ns);
    if (result.messages++ % kProgressStride == 0) progress(file.offset(), file.size());
  }
  if (result.messages == 0 && !has_metadata) {
    throw UserError(input.string(),
                    fmt::format("there is nothing to recover: in its {} bytes there is no message and no description "
                                "that can be read",
                                file.size()),
                    "is it the right file, and was all of it copied?");
  }
}

}  // namespace

std::string utc_text(std::int64_t utc_ns) {
  const std::time_t seconds = utc_ns / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:06} UTC", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec, utc_ns % 1'000'000'000 / 1000);
}

std::vector<std::string> damage_lines(std::span<const McapDamage> damages, std::uint64_t count, std::uint64_t bytes,
                                      const std::optional<MessageTimes>& times) {
  std::vector<std::string> lines;
  for (const McapDamage& damage : damages) {
    std::string line = fmt::format("byte {}: {}", damage.offset, damage.problem);
    const bool has_times = times && damage.start_ns && damage.end_ns && *damage.start_ns >= times->first_ns &&
                           *damage.start_ns <= *damage.end_ns && *damage.end_ns <= times->last_ns;
    if (has_times) {
      line += fmt::format("; it held messages from {} to {}", utc_text(*damage.start_ns), utc_text(*damage.end_ns));
    }
    lines.push_back(std::move(line));
  }
  if (count > damages.size()) lines.push_back(fmt::format("and {} more damaged places", count - damages.size()));
  if (count > 0) lines.push_back(fmt::format("{} damaged places, {} bytes that could not be read", count, bytes));
  return lines;
}

std::vector<std::string> gap_lines(const std::string& topic, const TopicAccount& account) {
  std::vector<std::string> lines;
  for (const SessionGap& gap : account.gaps) {
    const std::string when = gap.from_ns && gap.to_ns
                                 ? fmt::format("between {} and {}", utc_text(*gap.from_ns), utc_text(*gap.to_ns))
                             : gap.from_ns ? "after " + utc_text(*gap.from_ns)
                             : gap.to_ns   ? "before " + utc_text(*gap.to_ns)
                                           : std::string("of the session, all of them");
    lines.push_back(fmt::format("{} messages of {} {}", gap.missing, shown(topic), when));
  }
  if (account.gap_count > account.gaps.size()) {
    lines.push_back(fmt::format("and in {} more gaps of {}: {} messages of it in all",
                                account.gap_count - account.gaps.size(), shown(topic), account.missing));
  }
  return lines;
}

std::vector<std::string> missing_times(const RecoveredSession& session) {
  std::optional<MessageTimes> times;
  if (session.messages > 0) times = {session.first_ns, session.last_ns};
  std::vector<std::string> lines = damage_lines(session.damages, session.damage_count, session.damaged_bytes, times);
  for (const auto& [topic, account] : session.topics)
    std::ranges::move(gap_lines(topic, account), std::back_inserter(lines));
  if (!session.was_whole)
    lines.push_back(session.messages > 0 ? "everything after " + utc_text(session.last_ns) : "every message");
  return lines;
}

RecoveredSession recover_session(const std::filesystem::path& input, const std::filesystem::path& output,
                                 const std::function<void(std::uint64_t done, std::uint64_t of)>& progress) {
  RecoveredSession result;
  SessionReader reader(input);
  bool begun = false;
  try {
    Copy copy(output);
    begun = true;
    const UnfinishedPath unfinished(output);
    copy_all(input, copy, result, progress);
    while (reader.next()) {
    }
    result.damages = reader.file().damages();
    result.damage_count = reader.file().damage_count();
    result.damaged_bytes = reader.file().damaged_bytes();
    result.topics = reader.topics();
    result.was_whole = reader.file().whole();
    McapTexts texts{{"of", input.filename().string()}, {"messages", std::to_string(result.messages)}};
    const auto lines = missing_times(result);
    for (std::size_t i = 0; i < lines.size(); ++i) texts[fmt::format("{}{:04}", kMissingKey, i)] = lines[i];
    copy.write(McapMetadata{std::string(kRecoveryMetadata), texts});
    copy.finish();
  } catch (...) {
    if (begun) std::filesystem::remove(output);
    throw;
  }
  return result;
}

}  // namespace risorius
