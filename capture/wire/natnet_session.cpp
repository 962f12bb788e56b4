#include "capture/wire/natnet_session.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"
#include "capture/wire/byte_io.h"

namespace risorius {
namespace {

constexpr std::int32_t kRestartFrames = 100;  // a frame number that goes back farther is a server that began anew
constexpr std::int64_t kShortestRunNs = 1'000'000'000;
constexpr double kMostSeconds = 9e9;  // that fit into int64 ns

const NatnetOptions& checked(const NatnetOptions& options) {
  if (!(std::isfinite(options.mm_per_unit) && options.mm_per_unit > 0)) {
    throw UserError("mm_per_unit", fmt::format("{} is not a finite number > 0", options.mm_per_unit), "1000 for m");
  }
  if (options.timecode_rate < 1 || options.timecode_rate > 60) {
    throw UserError("timecode_rate", fmt::format("{} is out of range", options.timecode_rate), "1 to 60");
  }
  if (options.event_capacity < 8) {
    throw UserError("event_capacity", fmt::format("{} is out of range", options.event_capacity), "8 to 65536");
  }
  return options;
}

// False if the time does not fit.
bool ticks_to_ns(std::uint64_t ticks, std::uint64_t frequency, std::int64_t& time_ns) noexcept {
  constexpr std::uint64_t kMostFrequency = 10'000'000'000;  // of which a remainder times 1e9 fits
  if (frequency == 0 || frequency > kMostFrequency) return false;
  const std::uint64_t seconds = ticks / frequency, rest = ticks % frequency;
  if (seconds > static_cast<std::uint64_t>(kMostSeconds)) return false;
  time_ns = static_cast<std::int64_t>(seconds * 1'000'000'000 + (rest * 1'000'000'000 + frequency / 2) / frequency);
  return true;
}

}  // namespace

NatnetSession::NatnetSession(const NatnetOptions& options)
    : options_(checked(options)),
      events_(options.event_capacity),
      counters_(natnet_error_names()),
      extras_{{{"impossible_timecodes", &impossible_timecodes_}}} {
  counters_.extras = extras_;
  wait_ns_ = options_.first_wait_ns;
  counters_.link = LinkState::kConnecting;
}

bool NatnetSession::push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept {
  if (!ready()) return false;
  counters_.datagrams.received.add();
  NatnetPacket packet;
  NatnetError error = decode_natnet(datagram, packet);
  if (error == NatnetError::kNone) {
    heard_ns_ = receive_time_ns;
    error = take(packet, receive_time_ns);
  }
  if (error == NatnetError::kNone) {
    counters_.datagrams.emitted.add();
  } else {
    counters_.refuse(error);
  }
  counters_.frames.held.set(events_.waiting_frames());
  return true;
}

void NatnetSession::push_foreign() noexcept {
  counters_.datagrams.received.add();
  counters_.refuse(NatnetError::kUnknownSender);
}

NatnetError NatnetSession::take(const NatnetPacket& packet, std::int64_t now_ns) {
  switch (packet.message()) {
    case NatnetMessage::kFrameOfData:
      return take_frame(packet.payload, now_ns);
    case NatnetMessage::kServerInfo:
      return take_server_info(packet.payload, now_ns);
    case NatnetMessage::kModelDef:
      return take_model(packet.payload, now_ns);
    case NatnetMessage::kResponse:
      return take_response(packet.payload, now_ns);
    case NatnetMessage::kEchoResponse:
      return take_echo(packet.payload, now_ns);
    case NatnetMessage::kUnrecognizedRequest:
    case NatnetMessage::kUnrecognizedRequest256:
      if (phase_ == Phase::kAskingRate) enter(Phase::kAskingModel, now_ns);
      return NatnetError::kNone;
    case NatnetMessage::kDisconnect:
    case NatnetMessage::kDisconnectByTimeout:
      lose();
      return NatnetError::kNone;
    case NatnetMessage::kMessageString:
    case NatnetMessage::kKeepAlive:
      return NatnetError::kNone;
    default:
      return NatnetError::kUnknownMessage;
  }
}

NatnetError NatnetSession::take_server_info(std::span<const std::byte> payload, std::int64_t now_ns) {
  NatnetServerInfo info;
  if (const NatnetError error = decode_server_info(payload, info); error != NatnetError::kNone) return error;
  const bool same_server = server_ && server_->name == info.name && server_->clock_frequency == info.clock_frequency &&
                           server_->application_version == info.application_version;
  server_ = std::move(info);
  if (phase_ == Phase::kStreaming && same_server) {
    // Its version may be another one now; its models are asked for again, in case that it began anew.
    send(NatnetMessage::kRequestModelDef);
    return NatnetError::kNone;
  }
  if (phase_ != Phase::kConnecting && same_server) return NatnetError::kNone;  // it answers every form of CONNECT
  end_stream();
  if (session_ > 0) counters_.reconnects.add();
  counters_.link = LinkState::kWaiting;
  enter(Phase::kAskingRate, now_ns);
  return NatnetError::kNone;
}

NatnetError NatnetSession::take_response(std::span<const std::byte> payload, std::int64_t now_ns) {
  if (phase_ != Phase::kAskingRate) return NatnetError::kNone;
  ByteReader reader(payload);
  const auto rate_hz = reader.read<float>();
  if (reader.ok() && is_rate(static_cast<double>(rate_hz))) rate_hz_ = static_cast<double>(rate_hz);
  enter(Phase::kAskingModel, now_ns);
  return NatnetError::kNone;
}

NatnetError NatnetSession::take_model(std::span<const std::byte> payload, std::int64_t now_ns) {
  if (!server_) return NatnetError::kNotConnected;
  std::vector<NatnetAsset> model;
  if (const NatnetError error = decode_model(payload, server_->version, model); error != NatnetError::kNone)
    return error;
  if (const NatnetError error = map_.build(model, options_.markers); error != NatnetError::kNone) return error;
  changing_until_ns_ = INT64_MIN;
  return begin_or_change(now_ns);
}

/// The set of the map comes into force; in a new session if there is none.
NatnetError NatnetSession::begin_or_change(std::int64_t now_ns) {
  const MarkerSet* set = store(map_.names());
  if (set == nullptr) return NatnetError::kTooManySets;
  if (phase_ != Phase::kStreaming) {
    begin_session(now_ns);
    enter(Phase::kStreaming, now_ns);
  }
  use(set);
  return NatnetError::kNone;
}

void NatnetSession::begin_session(std::int64_t now_ns) noexcept {
  ++session_;
  began_ns_ = now_ns;
  counters_.sessions.add();
  events_.emit(SourceEventKind::kNewSession, session_);
  set_ = nullptr;
  stream_open_ = true;
  recording_ = false;
}

void NatnetSession::use(const MarkerSet* set) noexcept {
  if (set == set_) return;
  counters_.sets_changed.add();
  events_.emit(SourceEventKind::kMarkerSet, session_).set = set;
  set_ = set;
}

/// The server began anew, and we have not noticed its absence: what comes now is another run of it.
void NatnetSession::follow_restart(std::int64_t now_ns) noexcept {
  const MarkerSet* set = set_;
  end_stream();
  counters_.reconnects.add();
  begin_session(now_ns);
  use(set);
}

const MarkerSet* NatnetSession::store(const std::vector<std::string>& names) {
  for (const auto& known : sets_) {
    if (known->names == names && known->rate_hz == rate_hz_) return known.get();
  }
  if (sets_.size() == kMaxSets) return nullptr;
  MarkerSet set{.id = static_cast<std::uint32_t>(sets_.size() + 1), .names = names, .rate_hz = rate_hz_};
  set.mm_per_unit = options_.mm_per_unit;
  set.axes = options_.axes;
  sets_.push_back(std::make_unique<MarkerSet>(std::move(set)));
  return sets_.back().get();
}

NatnetError NatnetSession::take_frame(std::span<const std::byte> payload, std::int64_t now_ns) {
  if (!server_) return NatnetError::kNotConnected;
  if (set_ == nullptr || phase_ != Phase::kStreaming) return NatnetError::kUnknownModel;
  NatnetFrame frame;
  if (const NatnetError error = decode_frame(payload, server_->version, frame); error != NatnetError::kNone) {
    return error;
  }
  const bool restarted = goes_back(frame.frame_number, now_ns);
  watch(frame, restarted, now_ns);
  if (restarted) follow_restart(now_ns);
  last_frame_number_ = frame.frame_number;
  if (now_ns < changing_until_ns_) return NatnetError::kModelChanging;
  std::int64_t capture_time_ns = 0;
  if (!capture_time(frame.suffix, capture_time_ns)) return NatnetError::kBadTime;

  framed_ns_ = now_ns;
  counters_.link = LinkState::kStreaming;
  counters_.frames.received.add();
  const bool recording = (frame.suffix.params & NatnetSuffix::kRecording) != 0;
  if (std::exchange(recording_, recording) != recording)
    events_.emit(recording ? SourceEventKind::kRecordingStarted : SourceEventKind::kRecordingStopped, session_);
  MarkerFrame& out = events_.emit(SourceEventKind::kFrame, session_).frame;
  counters_.not_finite_markers.add(map_.place(frame, options_.mm_per_unit, options_.axes, out));
  out.header = {.stream_id = options_.stream_id,
                .set_id = set_->id,
                .sequence = static_cast<std::uint32_t>(frame.frame_number),
                .capture_time_ns = capture_time_ns,
                .receive_time_ns = now_ns,
                .timecode = timecode(frame.suffix)};
  return NatnetError::kNone;
}

/// So far, or after such a time, that it is no disorder of the network. A number that stands still is no new run, and
/// one that leaps to and fro begins at most one a second.
bool NatnetSession::goes_back(std::int32_t frame_number, std::int64_t now_ns) const noexcept {
  if (framed_ns_ == INT64_MIN) return false;
  const std::int64_t back = std::int64_t{last_frame_number_} - frame_number;
  if (now_ns - framed_ns_ >= options_.first_wait_ns) return back > 0;
  return back > kRestartFrames && now_ns - began_ns_ >= kShortestRunNs;
}

/// What a frame says of the server: each is acted upon once, when it begins.
void NatnetSession::watch(const NatnetFrame& frame, bool restarted, std::int64_t now_ns) {
  const bool models_changed = (frame.suffix.params & NatnetSuffix::kModelsChanged) != 0;
  if (!std::exchange(models_changed_bit_, models_changed) && models_changed) {
    changing_until_ns_ = now_ns + options_.first_wait_ns;
    send(NatnetMessage::kRequestModelDef);
  }
  const bool bitstream_changed = (frame.suffix.params & NatnetSuffix::kBitstreamChanged) != 0;
  const bool began_to_change = !std::exchange(bitstream_changed_bit_, bitstream_changed) && bitstream_changed;
  if (!began_to_change && !frame.other_layout && !restarted) return;
  if (difference_ns(now_ns, asked_version_ns_) < options_.first_wait_ns) return;
  asked_version_ns_ = now_ns;
  send_connect();
}

bool NatnetSession::capture_time(const NatnetSuffix& suffix, std::int64_t& time_ns) const noexcept {
  if (suffix.mid_exposure_ticks > 0 && ticks_to_ns(suffix.mid_exposure_ticks, server_->clock_frequency, time_ns))
    return true;
  // Takes that are played back have no exposure.
  if (!(std::abs(suffix.timestamp_s) < kMostSeconds)) return false;
  time_ns = std::llround(suffix.timestamp_s * 1e9);
  return true;
}

/// Hours, minutes, seconds and frames, a byte each; bit 6 of the frames is the drop-frame flag, as in SMPTE 12M.
Timecode NatnetSession::timecode(const NatnetSuffix& suffix) noexcept {
  if (suffix.timecode == 0 && suffix.timecode_sub == 0) return {};
  const auto byte = [&suffix](int shift) { return static_cast<std::uint8_t>((suffix.timecode >> shift) & 0xFF); };
  const Timecode timecode{.hours = byte(24),
                          .minutes = byte(16),
                          .seconds = byte(8),
                          .frames = static_cast<std::uint8_t>(byte(0) & 0x3F),
                          .frame_rate = options_.timecode_rate,
                          .drop_frame = options_.timecode_drop_frame || (byte(0) & 0x40) != 0};
  if (timecode.possible()) return timecode;
  impossible_timecodes_.add();
  return {};
}

NatnetError NatnetSession::take_echo(std::span<const std::byte> payload, std::int64_t now_ns) {
  NatnetEcho echo;
  if (const NatnetError error = decode_echo_response(payload, echo); error != NatnetError::kNone) return error;
  if (!server_ || echo_ticks_ == 0 || echo.client_ticks != echo_ticks_) return NatnetError::kNone;  // too late
  echo_ticks_ = 0;
  ClockSample sample{.sent_ns = static_cast<std::int64_t>(echo.client_ticks), .received_ns = now_ns};
  if (ticks_to_ns(echo.host_ticks, server_->clock_frequency, sample.tracker_ns)) clock_sample_ = sample;
  return NatnetError::kNone;
}

bool NatnetSession::pop(SourceEvent& event) noexcept {
  if (!events_.pop(event)) return false;
  if (event.kind == SourceEventKind::kFrame) {
    counters_.frames.emitted.add();
    counters_.frames.held.set(events_.waiting_frames());
  }
  return true;
}

bool NatnetSession::pop_clock_sample(ClockSample& sample) noexcept {
  if (!clock_sample_) return false;
  sample = *std::exchange(clock_sample_, std::nullopt);
  return true;
}

}  // namespace risorius
