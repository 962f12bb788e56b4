// A session's MCAP file as its readers need it: messages with their topic and stream, metadata collected as they come,
// and an account of what is there and what is missing. Reads on where the file is damaged, and says so.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/mcap/mcap_reader.h"
#include "replay/session/session_format.h"

namespace risorius {

/// Messages that are missing, after the one at from_ns and before the one at to_ns (ns UTC). Before a topic's first
/// message there is none; what follows its last is told by the report alone, `to_ns` then being the recorder's end.
struct SessionGap {
  std::optional<std::int64_t> from_ns, to_ns;
  std::uint64_t missing = 0;
};

/// Of one topic, whatever its channels.
struct TopicAccount {
  std::string encoding;
  std::uint64_t messages = 0, bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t missing = 0;
  static constexpr std::size_t kMostGaps = 100;
  std::vector<SessionGap> gaps;  ///< the first kMostGaps
  std::uint64_t gap_count = 0;   ///< of all

  std::uint32_t next_sequence = 0;

  void add_gap(const SessionGap& gap);
};

struct StreamFacts {
  std::string name, protocol, rig_json;
};

class SessionReader {
 public:
  /// Throws UserError if the file cannot be opened or is no MCAP file.
  explicit SessionReader(std::filesystem::path path);

  /// False at the end. Messages of topics that are not ours are counted, and passed over.
  bool next();
  SessionTopic topic() const noexcept { return channel_->topic; }
  const std::string& stream() const noexcept { return channel_->stream; }
  const McapMessage& message() const noexcept { return file_.message(); }

  // What has come so far; all that stands at the begin of a session's file has come with its first message.

  /// Empty if the file is no session's.
  const McapTexts& session() const noexcept { return session_; }
  const std::string& config_toml() const noexcept { return config_toml_; }
  const std::vector<StreamFacts>& streams() const noexcept { return streams_; }
  /// Null if there is none.
  const StreamFacts* find_stream(const std::string& name) const noexcept;
  /// After the end; empty if the recorder did not come to write it.
  const McapTexts& report() const noexcept { return report_; }
  const McapTexts& recovery() const noexcept { return recovery_; }
  const std::map<std::string, TopicAccount>& topics() const noexcept { return topics_; }
  std::uint64_t bytes_read() const noexcept { return file_.offset(); }
  std::uint64_t bytes() const noexcept { return file_.size(); }
  const McapReader& file() const noexcept { return file_; }
  /// Throws UserError if what was read says that this is no session of ours, or where all that could say so is damaged.
  void require_session() const;

 private:
  void take(const McapMetadata& metadata);
  void account(const McapChannel& channel, const McapMessage& message);
  void account_ends();

  McapReader file_;
  const SessionChannel* channel_ = nullptr;
  std::map<std::string, std::optional<SessionChannel>> known_topics_;
  McapTexts session_, report_, recovery_;
  std::string config_toml_;
  std::vector<StreamFacts> streams_;
  std::map<std::string, TopicAccount> topics_;
  bool ended_ = false;
};

}  // namespace risorius
