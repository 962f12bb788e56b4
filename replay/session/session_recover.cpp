#include "replay/session/session_recover.h"

#include <algorithm>
#include <ctime>
#include <fmt/format.h>
#include <utility>

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
    const auto known = std::ranges::find(channels_, channel, [](const auto& entry) { return entry.first; });
    if (known != channels_.end()) return known->second;
    std::uint16_t schema = 0;
    if (const auto found = schemas.find(channel.schema_id); found != schemas.end()) schema = schema_of(found->second);
    channels_.emplace_back(channel,
                           file_.add_channel(schema, channel.topic, channel.message_encoding, channel.metadata));
    return channels_.back().second;
  }
  std::uint16_t schema_of(const McapSchema& schema) {
    const auto known = std::ranges::find(schemas_, schema, [](const auto& entry) { return entry.first; });
    if (known != schemas_.end()) return known->second;
    schemas_.emplace_back(schema, file_.add_schema(schema.name, schema.encoding, schema.data));
    return schemas_.back().second;
  }

  McapWriter file_;
  std::vector<std::pair<McapChannel, std::uint16_t>> channels_;
  std::vector<std::pair<McapSchema, std::uint16_t>> schemas_;
};

void copy_all(const std::filesystem::path& input, Copy& copy, RecoveredSession& result,
              const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  McapReader file(input);
  for (auto item = file.next(); item != McapReader::Item::kEnd; item = file.next()) {
    if (item == McapReader::Item::kMetadata) {
      copy.write(file.metadata());
      continue;
    }
    copy.write(file);
    const std::int64_t time_ns = file.message().log_time_ns;
    result.first_ns = result.messages == 0 ? time_ns : std::min(result.first_ns, time_ns);
    result.last_ns = std::max(result.last_ns, time_ns);
    if (result.messages++ % kProgressStride == 0) progress(file.offset(), file.size());
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

std::vector<std::string> missing_times(const RecoveredSession& session) {
  std::vector<std::string> lines;
  for (const McapDamage& damage : session.damages) {
    std::string line = fmt::format("byte {}: {}", damage.offset, damage.problem);
    if (damage.start_ns && damage.end_ns) {
      line += fmt::format("; it held messages from {} to {}", utc_text(*damage.start_ns), utc_text(*damage.end_ns));
    }
    lines.push_back(std::move(line));
  }
  for (const auto& [topic, account] : session.topics) {
    for (const SessionGap& gap : account.gaps) {
      lines.push_back(fmt::format("{}: {} messages between {} and {}", topic, gap.missing, utc_text(gap.from_ns),
                                  utc_text(gap.to_ns)));
    }
  }
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
    result.topics = reader.topics();
    result.was_whole = reader.file().whole();
    McapTexts texts{{"of", input.filename().string()}, {"messages", std::to_string(result.messages)}};
    const auto lines = missing_times(result);
    for (std::size_t i = 0; i < lines.size(); ++i) texts[fmt::format("missing {:04}", i)] = lines[i];
    copy.write(McapMetadata{std::string(kRecoveryMetadata), texts});
    copy.finish();
  } catch (...) {
    if (begun) std::filesystem::remove(output);
    throw;
  }
  return result;
}

}  // namespace risorius
