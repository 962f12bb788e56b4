#include "replay/session/session_writer.h"

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "replay/session/tick_codec.h"

namespace risorius {
namespace {

/// Of one stream; what others send beyond that shares a channel, so that a forged flood cannot grow the file's head.
constexpr std::size_t kMostOrigins = 32;

std::size_t index_of(SessionTopic topic) { return static_cast<std::size_t>(topic); }

/// None if it is no rig.
std::vector<std::string> au_names(const std::string& rig_json) {
  std::vector<std::string> names;
  const auto rig = nlohmann::json::parse(rig_json, nullptr, false);
  if (!rig.is_object() || !rig.contains("aus")) return names;
  for (const auto& au : rig.at("aus")) names.push_back(au.value("name", ""));
  return names;
}

}  // namespace

SessionWriter::SessionWriter(std::filesystem::path path, SessionDescription description)
    : path_(std::move(path)),
      description_(std::move(description)),
      file_(path_),
      utc_minus_monotonic_ns_(description_.utc_ns - description_.monotonic_ns) {
  marker_view_schema_ =
      file_.add_schema(std::string(kMarkerViewSchemaName), "jsonschema", std::string(marker_view_schema()));
  status_channel_ = file_.add_channel(0, session_topic(SessionTopic::kStatus, ""), "msgpack");
  topics_.push_back(session_topic(SessionTopic::kStatus, ""));
  for (const SessionStream& stream : description_.streams) add_stream(stream);
  for (int copy = 0; copy < 2; ++copy) describe();
  bytes_.set(file_.bytes_written());
}

void SessionWriter::describe() {
  McapTexts facts = description_.facts;
  facts["format"] = std::string(kSessionFormat);
  facts["version"] = std::string(kSessionVersion);
  facts["monotonic_ns"] = std::to_string(description_.monotonic_ns);
  facts["utc_ns"] = std::to_string(description_.utc_ns);
  file_.write_metadata({std::string(kSessionMetadata), facts});
  file_.write_metadata({std::string(kConfigMetadata), {{"toml", description_.config_toml}}});
  for (const SessionStream& stream : description_.streams) {
    file_.write_metadata({std::string(kStreamMetadata),
                          {{"name", stream.name}, {"protocol", stream.protocol}, {"rig", stream.rig_json}}});
  }
}

void SessionWriter::add_stream(const SessionStream& stream) {
  Stream& state = streams_.emplace_back();
  const std::uint16_t au_view_schema = file_.add_schema(au_view_schema_name(stream.name), "jsonschema",
                                                        risorius::au_view_schema(au_names(stream.rig_json)));
  for (const SessionTopic topic : {SessionTopic::kTicks, SessionTopic::kAus, SessionTopic::kContinuations,
                                   SessionTopic::kAuView, SessionTopic::kMarkerView, SessionTopic::kSets}) {
    const std::uint16_t schema = topic == SessionTopic::kAuView       ? au_view_schema
                                 : topic == SessionTopic::kMarkerView ? marker_view_schema_
                                                                      : std::uint16_t{0};
    topics_.push_back(session_topic(topic, stream.name));
    state.channels[index_of(topic)] = file_.add_channel(
        schema, topics_.back(), std::string(kSessionTopicNames[index_of(topic)].encoding), {{"stream", stream.name}});
  }
  state.channels[index_of(SessionTopic::kStatus)] = status_channel_;
}

std::uint16_t SessionWriter::raw_channel(std::uint32_t stream, const RawOrigin& origin) {
  Stream& state = streams_[stream];
  const auto known = std::ranges::find(state.raw_channels, origin, [](const auto& entry) { return entry.first; });
  if (known != state.raw_channels.end()) return known->second;
  if (state.raw_channels.size() > kMostOrigins) return state.raw_channels.back().second;
  const bool last = state.raw_channels.size() == kMostOrigins;
  const SessionStream& described = description_.streams[stream];
  topics_.push_back(session_topic(SessionTopic::kRaw, described.name));
  const std::uint16_t channel = file_.add_channel(
      0, topics_.back(), std::string(kSessionTopicNames[index_of(SessionTopic::kRaw)].encoding),
      {{"stream", described.name}, {"protocol", described.protocol}, {"source", last ? "others" : text_of(origin)}});
  state.raw_channels.emplace_back(last ? RawOrigin{.ip_version = 255} : origin, channel);
  return channel;
}

void SessionWriter::append(std::uint16_t channel, std::uint32_t sequence, std::int64_t time_ns,
                           std::span<const std::byte> bytes) {
  const std::int64_t utc_ns = std::max<std::int64_t>(0, time_ns + utc_minus_monotonic_ns_);
  if (file_.chunk_bytes() == 0) chunk_begin_ns_ = time_ns;
  file_.write(
      {.channel_id = channel, .sequence = sequence, .log_time_ns = utc_ns, .publish_time_ns = utc_ns, .data = bytes});
  ++in_chunk_[channel];
  if (file_.chunk_bytes() >= kChunkBytes) end_chunk();
}

/// What a chunk's frames mean is in their chunk: the set that is in force stands before the first of them.
void SessionWriter::write_tick(Stream& stream, std::uint32_t sequence, std::int64_t time_ns,
                               std::span<const std::byte> bytes) {
  if (is_marker_set_tick(bytes)) {
    stream.set_tick.assign(bytes.begin(), bytes.end());
    stream.chunk_of_set_tick = chunks_;
  } else {
    // Again, if the set itself filled its chunk.
    while (stream.chunk_of_set_tick != chunks_ && !stream.set_tick.empty()) write_set(stream, time_ns);
  }
  append(stream.channels[index_of(SessionTopic::kTicks)], sequence, time_ns, bytes);
}

/// All of a topic that is no loss when it is lost have the sequence 0.
void SessionWriter::write_set(Stream& stream, std::int64_t time_ns) {
  stream.chunk_of_set_tick = chunks_;
  append(stream.channels[index_of(SessionTopic::kSets)], 0, time_ns, stream.set_tick);
}

void SessionWriter::append_text(SessionTopic topic, Stream& stream, std::uint32_t& sequence, std::int64_t time_ns,
                                const std::string& text) {
  if (text.empty()) return;
  append(stream.channels[index_of(topic)], sequence++, time_ns, std::as_bytes(std::span(text.data(), text.size())));
}

void SessionWriter::write_raw(std::uint32_t stream, std::uint32_t sequence, std::int64_t time_ns,
                              const RawOrigin& origin, std::span<const std::byte> bytes) noexcept {
  try {
    append(raw_channel(stream, origin), sequence, time_ns, bytes);
  } catch (const std::exception& error) {
    note_problem(error.what());
  }
}

void SessionWriter::write(SessionTopic topic, std::uint32_t stream, std::uint32_t sequence, std::int64_t time_ns,
                          std::span<const std::byte> bytes) noexcept {
  try {
    if (topic == SessionTopic::kStatus) return append(status_channel_, sequence, time_ns, bytes);
    Stream& state = streams_[stream];
    if (topic == SessionTopic::kTicks) return write_tick(state, sequence, time_ns, bytes);
    if (topic == SessionTopic::kSets) {
      state.set_tick.assign(bytes.begin(), bytes.end());
      return write_set(state, time_ns);
    }
    const std::int64_t utc_ns = time_ns + utc_minus_monotonic_ns_;
    if (topic == SessionTopic::kMarkerView) {
      return append_text(topic, state, state.marker_views, time_ns, marker_view_json(bytes, utc_ns));
    }
    append(state.channels[index_of(topic)], sequence, time_ns, bytes);
    if (topic == SessionTopic::kAus && state.au_view.takes(time_ns))
      append_text(SessionTopic::kAuView, state, state.au_views, time_ns, au_view_json(bytes, utc_ns));
  } catch (const std::exception& error) {
    note_problem(error.what());
  }
}

void SessionWriter::keep_time(std::int64_t now_ns) noexcept {
  if (file_.chunk_bytes() > 0 && now_ns - chunk_begin_ns_ >= kChunkNs) end_chunk();
}

/// What the disk refuses is lost and counted; the file goes on as soon as there is room again.
void SessionWriter::end_chunk() noexcept {
  bool written = true;
  try {
    file_.end_chunk();
  } catch (const std::exception& error) {
    note_problem(error.what());
    written = false;
  }
  for (const auto& [channel, count] : in_chunk_) {
    Account& account = accounts_[topics_[channel]];
    (written ? account.written : account.not_written) += count;
    (written ? messages_ : not_written_).add(count);
  }
  in_chunk_.clear();
  ++chunks_;
  bytes_.set(file_.bytes_written());
}

void SessionWriter::finish(const McapTexts& texts) noexcept {
  if (std::exchange(finished_, true)) return;
  end_chunk();
  try {
    McapTexts report = texts;
    for (const auto& [topic, account] : accounts_) {
      report[fmt::format("written {}", topic)] = std::to_string(account.written);
      report[fmt::format("not_written {}", topic)] = std::to_string(account.not_written);
    }
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      const auto offered = [&](SessionTopic topic, std::uint32_t count) {
        if (count > 0)
          report[std::string(kOfferedKey) + session_topic(topic, description_.streams[i].name)] = std::to_string(count);
      };
      offered(SessionTopic::kAuView, streams_[i].au_views);
      offered(SessionTopic::kMarkerView, streams_[i].marker_views);
    }
    report["first_error"] = problem();
    for (int copy = 0; copy < 2; ++copy) file_.write_metadata({std::string(kReportMetadata), report});
    file_.finish();
  } catch (const std::exception& error) {
    note_problem(error.what());
  }
  bytes_.set(file_.bytes_written());
}

std::string SessionWriter::problem() const {
  const std::scoped_lock lock(problem_mutex_);
  return problem_;
}

void SessionWriter::note_problem(const std::string& what) noexcept {
  const std::scoped_lock lock(problem_mutex_);
  if (problem_.empty()) problem_ = what;
}

}  // namespace risorius
