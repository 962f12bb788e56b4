#include "capture/wire/live_link_session.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr double kDayS = 86400;
constexpr double kLongestBackS = 0.5;    // the network does not hold a packet up for longer
constexpr double kLongestAheadS = 10.0;  // a longer hole ends a take anyway
// What a shape can be, as in a recording; beyond, it is something else.
constexpr float kLeastShape = -0.2F, kMostShape = 2.0F;

constexpr std::array<std::string_view, 9> kReasons{"none", "version",      "device_id", "name", "truncated",
                                                   "time", "other_device", "leap",      "rates"};

const LiveLinkOptions& checked(const LiveLinkOptions& options) {
  if (options.rate_hz != 0 && !(options.rate_hz >= 1 && options.rate_hz <= 1000)) {
    throw UserError("rate_hz", fmt::format("{} is out of range", options.rate_hz),
                    "1 to 1000 frames per second, or 0 = as the packets say");
  }
  if (options.device.size() > kMaxLiveLinkNameBytes) {
    throw UserError("device", fmt::format("\"{}\" is longer than {} bytes", options.device, kMaxLiveLinkNameBytes),
                    "give the subject name that the app shows");
  }
  return options;
}

bool is_drop_frame(std::int32_t fps, std::int32_t denominator) noexcept {
  return denominator == 1001 && (fps == 30000 || fps == 60000);
}

/// Frames that a drop-frame count leaves out per minute, but for each tenth.
std::int64_t dropped_per_minute(std::int64_t nominal) noexcept { return nominal / 15; }

}  // namespace

Timecode live_link_timecode(std::int32_t frame, std::int32_t fps, std::int32_t denominator) noexcept {
  const std::int64_t nominal = std::llround(static_cast<double>(fps) / denominator);
  if (nominal < 1 || nominal > 255 || frame < 0) return {};
  const bool drop = is_drop_frame(fps, denominator);
  std::int64_t count = frame;
  if (drop) {  // put the left-out numbers back
    const std::int64_t dropped = dropped_per_minute(nominal);
    const std::int64_t per_minute = 60 * nominal - dropped, per_ten = 600 * nominal - 9 * dropped;
    const std::int64_t in_ten = count % per_ten;
    count += 9 * dropped * (count / per_ten) + (in_ten >= dropped ? dropped * ((in_ten - dropped) / per_minute) : 0);
  }
  const std::int64_t seconds = count / nominal;
  return {.hours = static_cast<std::uint8_t>(seconds / 3600 % 24),
          .minutes = static_cast<std::uint8_t>(seconds / 60 % 60),
          .seconds = static_cast<std::uint8_t>(seconds % 60),
          .frames = static_cast<std::uint8_t>(count % nominal),
          .frame_rate = static_cast<std::uint8_t>(nominal),
          .drop_frame = drop};
}

LiveLinkSession::LiveLinkSession(const LiveLinkOptions& options)
    : options_(checked(options)),
      device_(options.device),
      has_device_(!options.device.empty()),
      events_(options.event_capacity),
      counters_(kReasons),
      extras_{SourceExtra{"frames_without_face", &frames_without_face_},
              SourceExtra{"values_unusable", &values_unusable_}} {
  device_.reserve(kMaxLiveLinkNameBytes);
  counters_.extras = extras_;
}

bool LiveLinkSession::is_ours(std::string_view name) {
  if (has_device_) return name == device_;
  device_ = name;
  has_device_ = true;
  return true;
}

bool LiveLinkSession::goes_on(double time) const noexcept {
  const double seconds = (time - newest_) / rate_hz_;
  return seconds >= -kLongestBackS && seconds <= kLongestAheadS;
}

/// The time since the session's first midnight. A day that does not have a whole number of frames is counted with or
/// without the numbers that drop-frame leaves out; the one that leads to the nearer time is meant.
double LiveLinkSession::on_from_midnight(double time, const LiveLinkPacket& packet) noexcept {
  const double half_day = kDayS / 2 * rate_hz_;
  const double here = midnights_ + time;
  if (std::abs(here - newest_) < half_day) return here;
  const auto nominal = std::llround(rate_hz_);
  const double whole = kDayS * static_cast<double>(nominal);
  // 24 hours of 6 times ten minutes, of which nine have left numbers out.
  const double dropped =
      packet.denominator == 1001 ? 24.0 * 6 * 9 * static_cast<double>(dropped_per_minute(nominal)) : 0;
  const double direction = here < newest_ ? 1 : -1;  // -1: a straggler from before midnight
  const double with = here + direction * whole, without = here + direction * (whole - dropped);
  const double best = std::abs(with - newest_) <= std::abs(without - newest_) ? with : without;
  if (direction > 0 && goes_on(best)) midnights_ = best - time;
  return best;
}

const MarkerSet* LiveLinkSession::set_of(double rate_hz) {
  const auto found = std::ranges::find(sets_, rate_hz, &MarkerSet::rate_hz);
  if (found != sets_.end()) return &*found;
  if (sets_.size() == kMaxRates) return nullptr;
  return &sets_.emplace_back(
      MarkerSet{.id = static_cast<std::uint32_t>(sets_.size()), .names = {}, .rate_hz = rate_hz});
}

bool LiveLinkSession::begin_session(const LiveLinkPacket& packet, double time) {
  rate_hz_ = packet.rate_hz();
  step_ = options_.rate_hz > 0 ? std::max(1.0, std::round(rate_hz_ / options_.rate_hz)) : 1;
  const MarkerSet* set = set_of(rate_hz_ / step_);
  if (set == nullptr) {
    counters_.refuse(LiveLinkRefusal::kRates);
    return false;
  }
  started_ = true;
  set_ = set;
  fps_ = packet.fps;
  denominator_ = packet.denominator;
  midnights_ = 0;
  leapt_to_.reset();
  newest_ = time;
  newest_sequence_ = static_cast<std::uint64_t>(std::max(0LL, std::llround(time / step_)));
  ++session_;
  counters_.sessions.add();
  counters_.sets_changed.add();
  events_.emit(SourceEventKind::kNewSession, session_);
  events_.emit(SourceEventKind::kMarkerSet, session_).set = set_;
  return true;
}

std::uint64_t LiveLinkSession::number(double time) noexcept {
  const double ahead = time - newest_;
  std::int64_t steps = std::llround(ahead / step_);
  if (ahead > 0) steps = std::max<std::int64_t>(steps, 1);
  if (ahead < 0) steps = std::min<std::int64_t>(steps, -1);
  const std::uint64_t sequence = newest_sequence_ + static_cast<std::uint64_t>(steps);
  if (ahead > 0) {
    newest_ = time;
    newest_sequence_ = sequence;
  }
  return sequence;
}

void LiveLinkSession::emit_frame(const LiveLinkPacket& packet, double time, std::int64_t receive_time_ns) noexcept {
  ShapeFrame& frame = events_.emit(SourceEventKind::kShapes, session_).shapes;
  frame = ShapeFrame{};
  frame.header = {.stream_id = options_.stream_id,
                  .set_id = set_->id,
                  .sequence = number(time),
                  .capture_time_ns = std::llround(time / rate_hz_ * 1e9),
                  .receive_time_ns = receive_time_ns,
                  .timecode = live_link_timecode(packet.frame, packet.fps, packet.denominator)};
  frame.has_face = packet.has_face;
  if (!packet.has_face) frames_without_face_.add();
  for (std::size_t i = 0; i < kFaceShapes && packet.has_face; ++i) {
    const bool usable = packet.value[i] >= kLeastShape && packet.value[i] <= kMostShape;
    frame.value[i] = usable ? packet.value[i] : ShapeFrame::kNone;
    if (!usable) values_unusable_.add();
  }
  counters_.datagrams.emitted.add();
  counters_.frames.received.add();
  counters_.frames.held.set(events_.waiting_frames());
}

bool LiveLinkSession::push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept {
  if (!ready()) return false;
  counters_.datagrams.received.add();
  LiveLinkPacket packet;
  if (const LiveLinkError error = decode_live_link(datagram, packet); error != LiveLinkError::kNone) {
    counters_.refuse(error);
    return true;
  }
  if (!is_ours(packet.name)) {
    counters_.refuse(LiveLinkRefusal::kOtherDevice);
    return true;
  }
  const double since_midnight = static_cast<double>(packet.frame) + static_cast<double>(packet.subframe);
  double time = since_midnight;
  if (!started_ || packet.fps != fps_ || packet.denominator != denominator_) {
    if (!begin_session(packet, time)) return true;
  } else if (time = on_from_midnight(since_midnight, packet); !goes_on(time)) {
    const bool again =
        leapt_to_ && since_midnight > *leapt_to_ && since_midnight - *leapt_to_ <= kLongestAheadS * rate_hz_;
    if (!again) {
      leapt_to_ = since_midnight;
      counters_.refuse(LiveLinkRefusal::kLeap);
      return true;
    }
    time = since_midnight;
    if (!begin_session(packet, time)) return true;
  }
  leapt_to_.reset();
  emit_frame(packet, time, receive_time_ns);
  return true;
}

bool LiveLinkSession::pop(SourceEvent& event) noexcept {
  if (!events_.pop(event)) return false;
  if (event.kind == SourceEventKind::kShapes) counters_.frames.emitted.add();
  counters_.frames.held.set(events_.waiting_frames());
  return true;
}

}  // namespace risorius
