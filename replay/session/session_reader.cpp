#include "replay/session/session_reader.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"

namespace risorius {
namespace {

std::string text_of(const McapTexts& texts, const char* key) {
  const auto found = texts.find(key);
  return found == texts.end() ? std::string() : found->second;
}

std::optional<std::int64_t> number_of(const std::string& text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

}  // namespace

SessionReader::SessionReader(std::filesystem::path path) : file_(std::move(path)) {}

bool SessionReader::next() {
  while (true) {
    switch (file_.next()) {
      case McapReader::Item::kEnd:
        account_ends();
        return false;
      case McapReader::Item::kMetadata:
        take(file_.metadata());
        break;
      case McapReader::Item::kMessage: {
        const McapChannel& channel = file_.channels().at(file_.message().channel_id);
        account(channel, file_.message());
        auto& known = known_topics_.try_emplace(channel.topic, parse_session_topic(channel.topic)).first->second;
        if (!known) break;
        channel_ = &*known;
        return true;
      }
    }
  }
}

/// The description is there twice, and its begin cannot be anybody else's: the first one counts. Of reports the last.
void SessionReader::take(const McapMetadata& metadata) {
  if (metadata.name == kSessionMetadata && session_.empty()) session_ = metadata.texts;
  if (metadata.name == kConfigMetadata && config_toml_.empty()) config_toml_ = text_of(metadata.texts, "toml");
  if (metadata.name == kReportMetadata) report_ = metadata.texts;
  if (metadata.name == kRecoveryMetadata) recovery_ = metadata.texts;
  if (const std::string name = text_of(metadata.texts, "name");
      metadata.name == kStreamMetadata && find_stream(name) == nullptr)
    streams_.push_back({name, text_of(metadata.texts, "protocol"), text_of(metadata.texts, "rig")});
}

void TopicAccount::add_gap(const SessionGap& gap) {
  missing += gap.missing;
  ++gap_count;
  if (gaps.size() < kMostGaps) gaps.push_back(gap);
}

/// Our sequences count what was offered to the topic, so a step of more than one is a loss.
void SessionReader::account(const McapChannel& channel, const McapMessage& message) {
  TopicAccount& topic = topics_[channel.topic];
  const auto step = message.sequence - topic.next_sequence;  // modulo 2^32, as it is counted
  // Half the numbers lie behind: of other recorders, whose sequences mean something else.
  if (step > 0 && step < 0x80000000U && !session_.empty()) {
    const auto before = topic.messages > 0 ? std::optional(topic.last_ns) : std::nullopt;
    topic.add_gap({before, message.log_time_ns, step});
  }
  topic.next_sequence = message.sequence + 1;
  topic.first_ns = topic.messages == 0 ? message.log_time_ns : std::min(topic.first_ns, message.log_time_ns);
  topic.last_ns = topic.messages == 0 ? message.log_time_ns : std::max(topic.last_ns, message.log_time_ns);
  topic.encoding = channel.message_encoding;
  ++topic.messages;
  topic.bytes += message.data.size();
}

/// What is missing after a topic's last message: the recorder's report knows how many there were. Once.
void SessionReader::account_ends() {
  if (std::exchange(ended_, true)) return;
  const auto end_ns = number_of(text_of(report_, std::string(kEndKey).c_str()));
  for (const auto& [key, value] : report_) {
    const auto offered = number_of(value);
    if (!key.starts_with(kOfferedKey) || !offered) continue;
    TopicAccount& topic = topics_[key.substr(kOfferedKey.size())];
    const auto step = static_cast<std::uint32_t>(*offered) - topic.next_sequence;  // modulo 2^32, as it is counted
    if (step == 0 || step >= 0x80000000U) continue;
    if (topic.messages == 0) topic.first_ns = topic.last_ns = end_ns.value_or(0);
    topic.add_gap({topic.messages > 0 ? std::optional(topic.last_ns) : std::nullopt, end_ns, step});
  }
}

const StreamFacts* SessionReader::find_stream(const std::string& name) const noexcept {
  const auto found = std::ranges::find(streams_, name, &StreamFacts::name);
  return found == streams_.end() ? nullptr : &*found;
}

void SessionReader::require_session() const {
  if (session_.empty() && file_.damage_count() > 0) {
    const McapDamage& first = file_.damages().front();
    throw UserError(file_.path().string(),
                    fmt::format("what it says of its session is damaged (byte {}: {})", first.offset, first.problem),
                    "risorius info says what is there");
  }
  const std::string format = text_of(session_, "format"), version = text_of(session_, "version");
  if (format != kSessionFormat) {
    throw UserError(file_.path().string(), "is no session that risoriusd recorded",
                    "give a file of [record] session; `risorius info` reads any MCAP file");
  }
  if (version != kSessionVersion) {
    throw UserError(file_.path().string(), "is of version " + shown(version) + " of the format",
                    "this program reads version " + std::string(kSessionVersion));
  }
}

}  // namespace risorius
