// The names in a session's MCAP file; replay/README.md, "Session files", says what each holds.
#pragma once

#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <string_view>

#include "replay/mcap/mcap_records.h"

namespace risorius {

inline constexpr std::string_view kSessionFormat = "risorius-session";
inline constexpr std::string_view kSessionVersion = "1";

// Metadata records.
inline constexpr std::string_view kSessionMetadata = "session", kConfigMetadata = "config", kStreamMetadata = "stream",
                                  kReportMetadata = "report", kRecoveryMetadata = "recovery";

/// The kinds of channels; each but kStatus is there once for each stream.
enum class SessionTopic : std::uint8_t { kRaw, kTicks, kAus, kContinuations, kStatus, kAuView, kMarkerView, kSets };
inline constexpr std::size_t kSessionTopicCount = 8;

struct SessionTopicName {
  std::string_view suffix, encoding;
};
inline constexpr std::array<SessionTopicName, kSessionTopicCount> kSessionTopicNames{{
    {"raw", "x-risorius-raw"},
    {"ticks", "x-risorius-tick"},
    {"au", "msgpack"},
    {"continuation", "msgpack"},
    {"status", "msgpack"},
    {"view/au", "json"},
    {"view/markers", "json"},
    {"sets", "x-risorius-tick"},
}};

/// "/anna/ticks"; "/status" has no stream.
/// Begins the report's keys that say how many messages were offered to a topic: what lacks at its end shows in no gap.
/// In the recovery: "missing 0007".
inline constexpr std::string_view kMissingKey = "missing ";
inline constexpr std::string_view kOfferedKey = "offered ";
/// Of the report: when the recorder ended, ns UTC.
inline constexpr std::string_view kEndKey = "end_utc_ns";

inline std::string session_topic(SessionTopic topic, std::string_view stream) {
  const std::string_view suffix = kSessionTopicNames[static_cast<std::size_t>(topic)].suffix;
  return topic == SessionTopic::kStatus ? fmt::format("/{}", suffix) : fmt::format("/{}/{}", stream, suffix);
}

struct SessionChannel {
  SessionTopic topic = SessionTopic::kRaw;
  std::string stream;
};
/// Empty if the topic is none of ours. Names of streams have no slash.
inline std::optional<SessionChannel> parse_session_topic(std::string_view name) {
  if (name == "/status") return SessionChannel{SessionTopic::kStatus, ""};
  const auto slash = name.find('/', 1);
  if (!name.starts_with('/') || slash == std::string_view::npos) return std::nullopt;
  for (std::size_t i = 0; i < kSessionTopicCount; ++i) {
    if (kSessionTopicNames[i].suffix == name.substr(slash + 1))
      return SessionChannel{static_cast<SessionTopic>(i), std::string(name.substr(1, slash - 1))};
  }
  return std::nullopt;
}

}  // namespace risorius
