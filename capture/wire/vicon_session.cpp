#include "capture/wire/vicon_session.h"

#include <algorithm>
#include <cmath>

#include "capture/wire/vicon_packet_writer.h"

namespace risorius {
namespace {

constexpr std::array<std::string_view, 9> kReasons{"bad_tag",    "too_long",         "bad_object",
                                                   "bad_length", "bad_names",        "no_names",
                                                   "no_markers", "too_many_markers", "too_many_sets"};
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kGreetingTimeoutNs = 5 * kSecond;
constexpr std::int64_t kPingPeriodNs = kSecond;
constexpr std::int64_t kSilenceTimeoutNs = 5 * kSecond;
constexpr std::array kWanted{ViconId::kStreamInfo,    ViconId::kSubjectInfo,     ViconId::kFrameInfo,
                             ViconId::kLabeledRecons, ViconId::kUnlabeledRecons, ViconId::kTimecode,
                             ViconId::kLatencyInfo,   ViconId::kApplicationInfo, ViconId::kPing,
                             ViconId::kContents};

ViconRefusal refusal_of(ViconError error) noexcept {
  switch (error) {
    case ViconError::kBadTag:
      return ViconRefusal::kBadTag;
    case ViconError::kTooLong:
      return ViconRefusal::kTooLong;
    case ViconError::kBadObject:
      return ViconRefusal::kBadObject;
    default:
      return ViconRefusal::kBadLength;
  }
}

/// 0, none, if it is not that of a rate.
std::int64_t stated_period(std::int64_t ticks) noexcept {
  return ticks > 0 && is_rate(kViconTicksPerSecond / static_cast<double>(ticks)) ? ticks : 0;
}

/// Keeps the value; false if there is none.
template <class T>
bool keep(std::optional<T> value, std::optional<T>& into) noexcept {
  if (value) into = value;
  return value.has_value();
}

}  // namespace

ViconSession::ViconSession(const ViconSessionOptions& options)
    : TrackerSession(options.tracker, kReasons),
      assumed_rate_hz_(options.rate_hz),
      names_(options.subject),
      extras_{{{"unlabelled_markers", &vicon_.unlabelled_markers},
               {"server_latency_us", &vicon_.latency_us},
               {"round_trip_us", &vicon_.round_trip_us},
               {"arrival_times", &vicon_.arrival_times}}} {
  counters().extras = extras_;
}

void ViconSession::connected(std::int64_t now_ns) {
  begin_connection();
  connected_ns_ = heard_ns_ = ping_sent_ns_ = now_ns;
  greeted_ = ping_answered_ = have_records_ = y_up_ = false;
  // What was behind this address before may have been another server, or scene.
  names_.forget();
  forget_set();
  set_refusal_.reset();
  period_ = 0;
  last_frame_.reset();
  asked_ids_.clear();
  counters().link = LinkState::kWaiting;
}

void ViconSession::disconnected() {
  emit_end_of_stream();
  note_link_lost();
}

std::size_t ViconSession::receive(std::span<const std::byte> bytes, std::int64_t receive_time_ns) {
  std::span<const std::byte> rest = bytes, objects;
  while (ready() && !failed()) {
    ViconError error = ViconError::kNone;
    const PacketStatus status = take_vicon_packet(rest, kMaxPacketBytes, objects, error);
    if (status == PacketStatus::kIncomplete) break;
    counters().datagrams.received.add();
    if (status == PacketStatus::kBad) {
      counters().refuse(refusal_of(error));
      fail();
      break;
    }
    heard_ns_ = receive_time_ns;
    take(objects, receive_time_ns);
  }
  return bytes.size() - rest.size();
}

bool ViconSession::read_object(const ViconObject& object, Contents& contents) {
  const auto body = object.body;
  switch (static_cast<ViconId>(object.id)) {
    case ViconId::kFrameInfo:
      return keep(decode_vicon_u32(body), contents.frame);
    case ViconId::kLabeledRecons:
      return keep(decode_vicon_recons(body, true), contents.labelled);
    case ViconId::kUnlabeledRecons:
      return keep(decode_vicon_recons(body, false), contents.unlabelled);
    case ViconId::kTimecode:
      return keep(decode_vicon_timecode(body), contents.timecode);
    case ViconId::kLatencyInfo:
      return keep(decode_vicon_latency_s(body), contents.latency_s);
    case ViconId::kStreamInfo:
      return keep(decode_vicon_i64(body), contents.period);
    case ViconId::kApplicationInfo:
      return keep(decode_vicon_u8(body), contents.y_up);
    case ViconId::kObjectEnums:
      return keep(decode_vicon_ids(body), contents.offered);
    case ViconId::kPing:
      return keep(decode_vicon_i64(body), contents.ping);
    case ViconId::kContents: {
      const auto read = decode_vicon_contents(body);
      if (read) contents.unchanged = read->unchanged;
      return read.has_value();
    }
    case ViconId::kSubjectInfo:
      subjects_.push_back(body);
      return true;
    default:
      return true;
  }
}

ViconError ViconSession::read(std::span<const std::byte> objects, Contents& contents) {
  subjects_.clear();
  while (!objects.empty()) {
    ViconObject object;
    if (!take_vicon_object(objects, object)) return ViconError::kBadObject;
    if (!read_object(object, contents)) return ViconError::kBadLength;
  }
  return ViconError::kNone;
}

void ViconSession::take(std::span<const std::byte> objects, std::int64_t time_ns) {
  Contents contents;
  if (const ViconError error = read(objects, contents); error != ViconError::kNone) {
    return counters().refuse(refusal_of(error));
  }
  if (const auto refusal = update_set(contents)) return counters().refuse(*refusal);
  if (contents.offered) answer_offer(*contents.offered);
  if (contents.ping) take_ping(*contents.ping, time_ns);
  if (contents.frame && *contents.frame != kViconNoFrame) return take_frame(contents, time_ns);
  counters().datagrams.emitted.add();
}

std::optional<ViconRefusal> ViconSession::update_set(const Contents& contents) {
  bool changed = false;
  if (!subjects_.empty()) {
    const ViconNames::Outcome outcome = names_.describe(subjects_);
    if (outcome == ViconNames::Outcome::kBad) return ViconRefusal::kBadNames;
    changed = outcome == ViconNames::Outcome::kChanged;
  }
  const std::int64_t period = contents.period ? stated_period(*contents.period) : period_;
  const bool y_up = contents.y_up ? *contents.y_up == 1 : y_up_;
  // Capture times are counted at the new rate from now on: those of before do not lead up to them.
  if (period != period_) end_session();
  changed = changed || period != period_ || y_up != y_up_;
  period_ = period;
  y_up_ = y_up;
  if (!changed) return {};
  have_records_ = false;
  set_refusal_.reset();
  if (names_.names().empty()) {
    forget_set();
    return {};
  }
  switch (describe({.names = names_.names(), .rate_hz = rate_hz(), .axes = *Axes::parse(y_up_ ? "FUR" : "FLU")})) {
    case Described::kTooManyMarkers:
      set_refusal_ = ViconRefusal::kTooManyMarkers;
      break;
    case Described::kTooManySets:
      set_refusal_ = ViconRefusal::kTooManySets;
      break;
    default:
      break;
  }
  return set_refusal_;
}

double ViconSession::rate_hz() const noexcept {
  return period_ > 0 ? kViconTicksPerSecond / static_cast<double>(period_) : assumed_rate_hz_;
}

void ViconSession::answer_offer(ViconIds offered) {
  std::vector<std::uint32_t> ids;
  for (const ViconId id : kWanted)
    if (offered.contains(static_cast<std::uint32_t>(id))) ids.push_back(static_cast<std::uint32_t>(id));
  if (greeted_ && ids == asked_ids_) return;
  ViconPacketWriter packet(outbox());
  packet.ids(ViconId::kObjectEnums, ids);
  packet.finish();
  if (!greeted_) {
    ViconPacketWriter push(outbox());
    push.u8(ViconId::kRequestFrame, 1);
    push.finish();
  }
  greeted_ = true;
  asked_ids_ = std::move(ids);
}

void ViconSession::take_ping(std::int64_t id, std::int64_t time_ns) noexcept {
  if (id != ping_id_) return;
  ping_answered_ = true;
  last_ping_ = ViconPing{.sent_ns = ping_sent_ns_, .received_ns = time_ns};
  vicon_.round_trip_us.set(static_cast<std::uint64_t>(std::max<std::int64_t>(0, time_ns - ping_sent_ns_) / 1000));
}

void ViconSession::take_frame(const Contents& contents, std::int64_t time_ns) {
  const bool as_before = !contents.labelled &&
                         contents.unchanged.contains(static_cast<std::uint32_t>(ViconId::kLabeledRecons)) &&
                         have_records_;
  if (set() == nullptr) return counters().refuse(set_refusal_.value_or(ViconRefusal::kNoNames));
  if (!contents.labelled && !as_before) return counters().refuse(ViconRefusal::kNoMarkers);
  if (last_frame_ == contents.frame) {
    counters().datagrams.dropped.add();
    return;
  }
  if (last_frame_ && *contents.frame < *last_frame_) end_session();
  last_frame_ = contents.frame;
  counters().datagrams.emitted.add();
  counters().frames.received.add();
  if (contents.labelled) place_records(contents);
  have_records_ = true;
  if (contents.unlabelled) vicon_.unlabelled_markers.add(contents.unlabelled->count);
  const double latency_us = contents.latency_s.value_or(0) * 1e6;
  if (latency_us >= 0 && latency_us < 1e12) vicon_.latency_us.set(static_cast<std::uint64_t>(latency_us));
  frame_.header.sequence = *contents.frame;
  frame_.header.capture_time_ns = capture_time_of(*contents.frame, time_ns);
  frame_.header.receive_time_ns = time_ns;
  frame_.header.timecode = contents.timecode ? contents.timecode->clock().value_or(Timecode{}) : Timecode{};
  emit_frame(frame_);
}

void ViconSession::place_records(const Contents& contents) {
  begin_frame(frame_);
  for (std::size_t i = 0; i < contents.labelled->count; ++i) {
    const ViconRecon recon = (*contents.labelled)[i];
    const auto marker = names_.find(recon.subject, recon.marker);
    if (!marker) {
      vicon_.unlabelled_markers.add();
    } else if (frame_.state[*marker] == MarkerState::kMissing) {  // the first record of a duplicate wins
      place(frame_, *marker, recon.position_mm[0], recon.position_mm[1], recon.position_mm[2]);
    }
  }
}

std::int64_t ViconSession::capture_time_of(std::uint32_t frame, std::int64_t receive_time_ns) noexcept {
  if (period_ > 0) {
    const double ticks = static_cast<double>(frame) * static_cast<double>(period_);
    const double ns = ticks * 1e9 / kViconTicksPerSecond;
    if (ns < 9e18) return std::llround(ns);
  } else if (assumed_rate_hz_ > 0) {
    return std::llround(static_cast<double>(frame) * 1e9 / assumed_rate_hz_);
  }
  vicon_.arrival_times.add();
  return receive_time_ns;
}

void ViconSession::send_ping(std::int64_t now_ns) {
  ViconPacketWriter packet(outbox());
  packet.i64(ViconId::kPing, ++ping_id_);
  packet.finish();
  ping_sent_ns_ = now_ns;
}

void ViconSession::tick(std::int64_t now_ns) {
  if (!greeted_) {
    if (now_ns - connected_ns_ > kGreetingTimeoutNs) fail();
    return;
  }
  // Old servers answer no Ping; then silence means nothing.
  if (ping_answered_ && now_ns - heard_ns_ > kSilenceTimeoutNs) return fail();
  if (now_ns - ping_sent_ns_ >= kPingPeriodNs) send_ping(now_ns);
}

}  // namespace risorius
