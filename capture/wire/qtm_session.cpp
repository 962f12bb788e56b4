#include "capture/wire/qtm_session.h"

#include <cmath>
#include <limits>
#include <utility>

#include "capture/wire/tracker_names.h"

namespace risorius {
namespace {

constexpr std::array<std::string_view, 13> kReasons{
    "too_short", "bad_size",       "bad_component", "bad_count",  "bad_type",         "bad_settings", "error_reply",
    "no_labels", "count_mismatch", "bad_time",      "no_markers", "too_many_markers", "too_many_sets"};
constexpr std::uint8_t kMarkersPart = 1, kUnlabelledPart = 2, kTimecodePart = 4;
constexpr std::int64_t kLongestWaitNs = 20'000'000;
/// Over UDP a frame may come a little after its successors; further back the server has started over.
constexpr std::uint32_t kDisorderFrames = 32;
/// QTM's timecode does not say its rate, and its settings only where an external time stamp is set up.
constexpr std::uint8_t kAssumedTimecodeRate = 30;

QtmRefusal refusal_of(QtmError error) noexcept {
  switch (error) {
    case QtmError::kTooShort:
      return QtmRefusal::kTooShort;
    case QtmError::kBadComponent:
      return QtmRefusal::kBadComponent;
    case QtmError::kBadCount:
      return QtmRefusal::kBadCount;
    default:
      return QtmRefusal::kBadSize;
  }
}

/// QTM rounds its time stamps to microseconds. Where one is a multiple of the frame period to that precision, the
/// multiple is the time: the same as that of the frame in a file.
std::int64_t capture_time_of(std::uint64_t timestamp_us, double frequency_hz) noexcept {
  const auto us = static_cast<double>(timestamp_us);
  const double periods = std::round(us * frequency_hz * 1e-6);
  if (frequency_hz > 0 && us < 9e15 && std::abs(periods * 1e6 / frequency_hz - us) < 1) {
    return std::llround(periods * 1e9 / frequency_hz);
  }
  return static_cast<std::int64_t>(timestamp_us) * 1000;
}

}  // namespace

QtmSession::QtmSession(const QtmSessionOptions& options)
    : TrackerSession(options.tracker, kReasons),
      dialog_(outbox()),
      extras_{{{"unlabelled_markers", &qtm_.unlabelled_markers},
               {"drop_rate_per_mille", &qtm_.drop_rate_per_mille},
               {"out_of_sync_rate_per_mille", &qtm_.out_of_sync_rate_per_mille}}},
      label_prefix_(options.label_prefix) {
  counters().extras = extras_;
}

void QtmSession::connected(std::int64_t now_ns) {
  begin_connection();
  forget_set();
  any_finished_ = false;
  expected_parts_ = kMarkersPart;
  counters().link = LinkState::kWaiting;
  dialog_.connected(udp_port_, now_ns);
}

void QtmSession::disconnected() {
  give_up_pending();
  emit_end_of_stream();
  set_recording(false);
  dialog_.disconnected();
  note_link_lost();
}

std::size_t QtmSession::receive(std::span<const std::byte> bytes, std::int64_t receive_time_ns) {
  std::span<const std::byte> rest = bytes;
  QtmPacket packet;
  while (ready() && !failed()) {
    const PacketStatus status = take_qtm_packet(rest, kMaxPacketBytes, packet);
    if (status == PacketStatus::kIncomplete) break;
    counters().datagrams.received.add();
    if (status == PacketStatus::kBad) {
      counters().refuse(QtmRefusal::kBadSize);
      fail();
      break;
    }
    take(packet, receive_time_ns);
  }
  return bytes.size() - rest.size();
}

void QtmSession::receive_datagram(std::span<const std::byte> datagram, std::int64_t receive_time_ns) {
  counters().datagrams.received.add();
  QtmPacket packet;
  if (const QtmError error = read_qtm_datagram(datagram, packet); error != QtmError::kNone) {
    return counters().refuse(risorius::refusal_of(error));
  }
  take(packet, receive_time_ns);
}

void QtmSession::take(const QtmPacket& packet, std::int64_t time_ns) {
  switch (packet.type) {
    case QtmPacketType::kData:
      take_data(packet.body, time_ns);
      break;
    case QtmPacketType::kError:
      // Versions are tried from the newest down: a refusal is the way, not a fault.
      if (dialog_.asks_version()) {
        used();
      } else {
        counters().refuse(QtmRefusal::kErrorReply);
      }
      dialog_.on_text(qtm_text(packet.body), true, time_ns);
      break;
    case QtmPacketType::kCommand:
      used();
      dialog_.on_text(qtm_text(packet.body), false, time_ns);
      break;
    case QtmPacketType::kXml:
      take_settings(packet.body, time_ns);
      break;
    case QtmPacketType::kEvent:
      take_event(packet.body, time_ns);
      break;
    case QtmPacketType::kNoMoreData:
      used();
      end_stream();
      counters().link = LinkState::kWaiting;
      dialog_.on_no_more_data(time_ns);
      break;
    case QtmPacketType::kC3dFile:
    case QtmPacketType::kDiscover:
    case QtmPacketType::kQtmFile:
      used();
      break;
    default:
      counters().refuse(QtmRefusal::kBadType);
      break;
  }
  check_dialog();
}

void QtmSession::check_dialog() noexcept {
  if (dialog_.failed()) fail();
}

void QtmSession::end_stream() noexcept {
  finish_pending();
  emit_end_of_stream();
  any_finished_ = false;
}

void QtmSession::take_event(std::span<const std::byte> body, std::int64_t time_ns) {
  const auto event = qtm_event(body);
  if (!event) return counters().refuse(QtmRefusal::kBadType);
  used();
  switch (*event) {
    case QtmEvent::kCaptureStarted:
      set_recording(true);
      break;
    case QtmEvent::kCaptureStopped:
      set_recording(false);
      break;
    case QtmEvent::kConnectionClosed:
    case QtmEvent::kRtFromFileStopped:
    case QtmEvent::kShuttingDown:
      end_stream();
      set_recording(false);
      break;
    default:
      break;
  }
  dialog_.on_event(*event, time_ns);
}

void QtmSession::take_settings(std::span<const std::byte> body, std::int64_t time_ns) {
  if (!dialog_.on_xml(qtm_text(body), time_ns)) return counters().refuse(QtmRefusal::kBadSettings);
  if (const auto refusal = update_set()) return counters().refuse(*refusal);
  used();
}

std::optional<QtmRefusal> QtmSession::update_set() {
  const QtmSettings& settings = dialog_.settings();
  if (!settings.labels || settings.labels->empty()) return {};
  // What has come of a frame was placed by the old labels.
  finish_pending();
  set_refusal_.reset();
  labels_ = settings.labels->size();
  labelled_.clear();
  TrackerNames names;
  // One more than there may be is refused, however many there are.
  for (std::size_t i = 0; i < labels_ && names.size() <= kMaxMarkers; ++i) {
    const std::string& label = (*settings.labels)[i];
    if (!label.starts_with(label_prefix_)) continue;
    labelled_.push_back(i);
    names.add(std::string_view(label).substr(label_prefix_.size()));
  }
  if (labelled_.empty()) {
    forget_set();
    return QtmRefusal::kNoMarkers;
  }
  switch (describe(
      {.names = names.take(), .rate_hz = settings.frequency_hz.value_or(0), .axes = qtm_axes(settings.axis_upwards)})) {
    case Described::kTooManyMarkers:
      set_refusal_ = QtmRefusal::kTooManyMarkers;
      break;
    case Described::kTooManySets:
      set_refusal_ = QtmRefusal::kTooManySets;
      break;
    default:
      break;
  }
  return set_refusal_;
}

std::optional<QtmRefusal> QtmSession::refusal_of(const QtmData& data) const noexcept {
  constexpr auto kLastMicrosecond = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() / 1000);
  if (set() == nullptr) return set_refusal_.value_or(QtmRefusal::kNoLabels);
  if (data.labelled && data.labelled->count != labels_) return QtmRefusal::kCountMismatch;
  if (data.timestamp_us > kLastMicrosecond) return QtmRefusal::kBadTime;
  return {};
}

void QtmSession::take_data(std::span<const std::byte> body, std::int64_t time_ns) {
  QtmData data;
  if (const QtmError error = decode_qtm_data(body, data); error != QtmError::kNone) {
    return counters().refuse(risorius::refusal_of(error));
  }
  dialog_.on_data(time_ns);
  if (const auto refusal = refusal_of(data)) {
    if (refusal == QtmRefusal::kCountMismatch) dialog_.refresh_labels(time_ns);
    return counters().refuse(*refusal);
  }
  if (!data.labelled && !data.unlabelled && !data.timecode) return used();
  if (pending_.active && pending_.frame != data.frame) {
    expected_parts_ &= pending_.parts | kMarkersPart;  // what did not come now is not waited for again
    finish_pending();
  }
  if (!pending_.active) {
    if (any_finished_ && data.frame == finished_frame_) {
      // A part that comes in a packet of its own: from the next frame on it is waited for.
      expected_parts_ |=
          static_cast<std::uint8_t>((data.unlabelled ? kUnlabelledPart : 0) | (data.timecode ? kTimecodePart : 0));
      counters().datagrams.dropped.add();
      return;
    }
    open_pending(data, time_ns);
  }
  add_parts(data);
  if ((pending_.parts & expected_parts_) == expected_parts_) finish_pending();
}

void QtmSession::open_pending(const QtmData& data, std::int64_t time_ns) {
  counters().frames.received.add();
  pending_.active = true;
  pending_.frame = data.frame;
  pending_.parts = 0;
  pending_.packets = 0;
  pending_.begun_ns = time_ns;
  begin_frame(pending_.markers);
  pending_.markers.header.sequence = data.frame;
  pending_.markers.header.capture_time_ns = capture_time_of(data.timestamp_us, set()->rate_hz);
  pending_.markers.header.receive_time_ns = time_ns;
}

void QtmSession::add_parts(const QtmData& data) {
  ++pending_.packets;
  if (data.labelled && (pending_.parts & kMarkersPart) == 0) {
    pending_.parts |= kMarkersPart;
    qtm_.drop_rate_per_mille.set(data.labelled->drop_rate_per_mille);
    qtm_.out_of_sync_rate_per_mille.set(data.labelled->out_of_sync_rate_per_mille);
    for (std::size_t i = 0; i < labelled_.size(); ++i) {
      const auto xyz = data.labelled->position(labelled_[i]);
      if (xyz) place(pending_.markers, i, double{(*xyz)[0]}, double{(*xyz)[1]}, double{(*xyz)[2]});
    }
  }
  if (data.unlabelled && (pending_.parts & kUnlabelledPart) == 0) {
    pending_.parts |= kUnlabelledPart;
    qtm_.unlabelled_markers.add(data.unlabelled->count);
  }
  if (data.timecode) {
    pending_.parts |= kTimecodePart;
    const double stated_hz = dialog_.settings().timecode_rate_hz.value_or(kAssumedTimecodeRate);
    const auto rate =
        stated_hz >= 1 && stated_hz <= 255 ? static_cast<std::uint8_t>(std::lround(stated_hz)) : kAssumedTimecodeRate;
    pending_.markers.header.timecode = data.timecode->clock(rate).value_or(Timecode{});
  }
  note_held(pending_.packets, 1);
}

void QtmSession::finish_pending() noexcept {
  if (!pending_.active) return;
  if ((pending_.parts & kMarkersPart) == 0) return give_up_pending();
  pending_.active = false;
  counters().datagrams.emitted.add(pending_.packets);
  note_held(0, 0);
  const std::uint32_t behind = finished_frame_ - pending_.frame;
  const bool started_over =
      any_finished_ && pending_.frame < finished_frame_ && (udp_port_ == 0 || behind > kDisorderFrames);
  if (started_over) end_session();
  any_finished_ = true;
  finished_frame_ = pending_.frame;
  emit_frame(pending_.markers);
}

void QtmSession::give_up_pending() noexcept {
  if (!std::exchange(pending_.active, false)) return;
  counters().datagrams.dropped.add(pending_.packets);
  counters().frames.dropped.add();
  counters().incomplete_frames.add();
  note_held(0, 0);
}

void QtmSession::tick(std::int64_t now_ns) {
  if (pending_.active && now_ns - pending_.begun_ns > kLongestWaitNs) {
    expected_parts_ &= pending_.parts | kMarkersPart;
    finish_pending();
  }
  dialog_.tick(now_ns);
  check_dialog();
}

void QtmSession::flush() noexcept { finish_pending(); }

}  // namespace risorius
