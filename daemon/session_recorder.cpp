#include "daemon/session_recorder.h"

#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/monotonic_clock.h"
#include "daemon/time_slice.h"
#include "replay/session/tick_codec.h"

namespace risorius {
namespace {

/// How often the thread looks into the rings. A session's data are on the disk after this and a chunk's time.
constexpr auto kLook = std::chrono::milliseconds(20);

/// What a message adds to the file beside its bytes, about: its record's head, its entry in the index.
constexpr std::size_t kRecordBytes = 64;
constexpr std::int64_t kSecondNs = 1'000'000'000;

void encode(const AdmittedItem& item, ByteAppender& out) {
  const std::string_view name(item.recording_name_bytes.data(), item.recording_name_size);
  switch (item.kind) {
    case AdmittedItem::Kind::kFrame:
      return encode_tick(item.frame, out);
    case AdmittedItem::Kind::kShapes:
      return encode_tick(item.shapes, out);
    case AdmittedItem::Kind::kMarkerSet:
      return encode_tick(*item.marker_set, out);
    case AdmittedItem::Kind::kEndOfStream:
      return encode_end_of_stream_tick(out);
    case AdmittedItem::Kind::kNeutralCapture:
      return encode_neutral_tick(item.duration_ns, out);
    case AdmittedItem::Kind::kRecordingStarted:
      return encode_recording_tick(true, name, out);
    case AdmittedItem::Kind::kRecordingStopped:
      return encode_recording_tick(false, name, out);
  }
}

}  // namespace

SessionRecorder::SessionRecorder(std::size_t streams, std::size_t ring_bytes)
    : keep_for_ticks_(ring_bytes / 4), received_(ring_bytes), results_(ring_bytes), streams_(streams) {}

SessionRecorder::~SessionRecorder() { stop(); }

void SessionRecorder::start(std::filesystem::path path, SessionDescription description) {
  for (const SessionStream& stream : description.streams) names_.push_back(stream.name);
  writer_ = std::make_unique<SessionWriter>(std::move(path), std::move(description));
  thread_ = std::thread([this] { run(); });
}

void SessionRecorder::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  ended_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void SessionRecorder::receive(void* self, std::uint32_t stream_id, const RawMessage& message) noexcept {
  auto& recorder = *static_cast<SessionRecorder*>(self);
  Stream& stream = recorder.streams_[stream_id];
  if (message.is_refused && !has_room_for_refused(stream, message)) {
    stream.refused_not_recorded.add();
    stream.refused_bytes_not_recorded.add(message.bytes.size());
    return;
  }
  const RecordRing::Head head{.kind = static_cast<std::uint16_t>(SessionTopic::kRaw),
                              .stream = static_cast<std::uint16_t>(stream_id),
                              .sequence = stream.raw++,
                              .time_ns = message.receive_time_ns};
  static_assert(std::is_trivially_copyable_v<RawOrigin>);
  const auto from = std::as_bytes(std::span<const RawOrigin, 1>(&message.origin, 1));
  if (!recorder.received_.try_push(head, from, message.bytes, recorder.keep_for_ticks_))
    recorder.dropped_datagrams_.add();
}

bool SessionRecorder::has_room_for_refused(Stream& stream, const RawMessage& message) noexcept {
  if (message.receive_time_ns - stream.second_begin_ns >= kSecondNs) {
    stream.second_begin_ns = message.receive_time_ns;
    stream.refused_bytes = 0;
  }
  const std::size_t bytes = stream.refused_bytes + message.bytes.size() + kRecordBytes;
  if (bytes > kMostRefusedBytes) return false;
  stream.refused_bytes = bytes;
  return true;
}

void SessionRecorder::admitted(const AdmittedItem& item) noexcept {
  Stream& stream = streams_[item.stream_id];
  RecordRing::Head head{.stream = static_cast<std::uint16_t>(item.stream_id), .time_ns = monotonic_now_ns()};
  const auto push = [&](SessionTopic topic, std::uint32_t sequence) {
    head.kind = static_cast<std::uint16_t>(topic);
    head.sequence = sequence;
    return received_.try_push(head, tick_.bytes());
  };
  const bool is_set = item.kind == AdmittedItem::Kind::kMarkerSet;
  if (is_set) stream.owed_set = nullptr;
  if (stream.owed_set != nullptr) {
    // Without their set the frames mean nothing: it goes ahead of the first that finds room again.
    encode_tick(*stream.owed_set, tick_);
    if (push(SessionTopic::kSets, 0)) stream.owed_set = nullptr;
  }
  encode(item, tick_);
  const std::uint32_t sequence = stream.ticks++;
  if (stream.owed_set == nullptr && push(SessionTopic::kTicks, sequence)) return;
  dropped_ticks_.add();
  if (is_set) stream.owed_set = item.marker_set;
}

void SessionRecorder::published(SessionTopic topic, std::uint32_t stream_id, std::span<const char> message,
                                std::int64_t time_ns) noexcept {
  RecordRing::Head head{
      .kind = static_cast<std::uint16_t>(topic), .stream = static_cast<std::uint16_t>(stream_id), .time_ns = time_ns};
  if (topic == SessionTopic::kStatus) {
    head.sequence = statuses_++;
  } else {
    Stream& stream = streams_[stream_id];
    if (topic == SessionTopic::kMarkerView && !stream.marker_view.takes(time_ns)) return;
    if (topic == SessionTopic::kAus) head.sequence = stream.aus++;
    if (topic == SessionTopic::kContinuations) head.sequence = stream.continuations++;
  }
  if (!results_.try_push(head, std::as_bytes(message))) dropped_results_.add();
}

void SessionRecorder::run() noexcept {
  ask_for_usual_slices();
  while (true) {
    std::unique_lock lock(mutex_);
    ended_.wait_for(lock, kLook, [this] { return stopping_; });
    const bool last_round = stopping_;
    lock.unlock();
    // First the mark: a result that is written now has its Tick in the file already.
    const std::size_t results_end = results_.end();
    drain(received_, received_.end());
    drain(results_, results_end);
    if (last_round) break;
    writer_->keep_time(monotonic_now_ns());
  }
  writer_->finish(report());
}

McapTexts SessionRecorder::report() const {
  McapTexts texts{{"dropped datagrams", std::to_string(dropped_datagrams_.value())},
                  {"dropped ticks", std::to_string(dropped_ticks_.value())},
                  {"dropped results", std::to_string(dropped_results_.value())},
                  {std::string(kEndKey), std::to_string(utc_now_ns())}};
  const auto offered = [&](SessionTopic topic, const std::string& stream, std::uint32_t count) {
    if (count > 0) texts[std::string(kOfferedKey) + session_topic(topic, stream)] = std::to_string(count);
  };
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    offered(SessionTopic::kRaw, names_[i], streams_[i].raw);
    offered(SessionTopic::kTicks, names_[i], streams_[i].ticks);
    offered(SessionTopic::kAus, names_[i], streams_[i].aus);
    offered(SessionTopic::kContinuations, names_[i], streams_[i].continuations);
    if (const std::uint64_t count = streams_[i].refused_not_recorded.value(); count > 0) {
      const std::string topic = session_topic(SessionTopic::kRaw, names_[i]);
      texts["refused_not_recorded " + topic] = std::to_string(count);
      texts["refused_bytes_not_recorded " + topic] = std::to_string(streams_[i].refused_bytes_not_recorded.value());
    }
  }
  offered(SessionTopic::kStatus, "", statuses_);
  return texts;
}

std::string SessionRecorder::problem() const {
  std::string problem = writer_ ? writer_->problem() : std::string();
  const std::uint64_t dropped = dropped_datagrams_.value() + dropped_ticks_.value() + dropped_results_.value();
  if (problem.empty() && dropped > 0) {
    problem = fmt::format(
        "{}: {} messages found their queue full and are missing (datagrams {}, ticks {}, results {}); "
        "give [queues] session_mib more, or a faster disk",
        writer_ ? writer_->path().string() : "", dropped, dropped_datagrams_.value(), dropped_ticks_.value(),
        dropped_results_.value());
  }
  return problem;
}

void SessionRecorder::drain(RecordRing& ring, std::size_t end) noexcept {
  while (const auto record = ring.front(end)) {
    const RecordRing::Head& head = record->head;
    const auto topic = static_cast<SessionTopic>(head.kind);
    if (topic == SessionTopic::kRaw) {
      RawOrigin origin;
      std::memcpy(&origin, record->payload.data(), sizeof origin);
      writer_->write_raw(head.stream, head.sequence, head.time_ns, origin, record->payload.subspan(sizeof origin));
    } else {
      writer_->write(topic, head.stream, head.sequence, head.time_ns, record->payload);
    }
    ring.release(*record);
  }
}

nlohmann::json SessionRecorder::status() const {
  std::uint64_t refused = 0, refused_bytes = 0;
  for (const Stream& stream : streams_) {
    refused += stream.refused_not_recorded.value();
    refused_bytes += stream.refused_bytes_not_recorded.value();
  }
  return {{"file", writer_ ? writer_->path().string() : ""},
          {"problem", problem()},
          {"bytes", writer_ ? writer_->bytes().value() : 0},
          {"messages", writer_ ? writer_->messages().value() : 0},
          {"not_written", writer_ ? writer_->not_written().value() : 0},
          {"dropped_datagrams", dropped_datagrams_.value()},
          {"dropped_ticks", dropped_ticks_.value()},
          {"dropped_results", dropped_results_.value()},
          {"refused_not_recorded", refused},
          {"refused_bytes_not_recorded", refused_bytes},
          {"queued_bytes", received_.size() + results_.size()},
          {"high_water_bytes", received_.high_water() + results_.high_water()}};
}

}  // namespace risorius
