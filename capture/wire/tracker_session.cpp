#include "capture/wire/tracker_session.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"
#include "capture/plausible_position.h"

namespace risorius {
namespace {

const TrackerSessionOptions& checked(const TrackerSessionOptions& options) {
  if (options.mm_per_unit && !(std::isfinite(*options.mm_per_unit) && *options.mm_per_unit > 0)) {
    throw UserError("mm_per_unit", fmt::format("{} is not a finite number > 0", *options.mm_per_unit),
                    "1 for mm, 10 for cm, 1000 for m");
  }
  if (options.event_capacity < 16 || options.event_capacity > 65536) {
    throw UserError("event_capacity", fmt::format("{} is out of range", options.event_capacity), "16 to 65536");
  }
  return options;
}

}  // namespace

TrackerSession::TrackerSession(const TrackerSessionOptions& options, std::span<const std::string_view> reasons)
    : options_(checked(options)), counters_(reasons), events_(options.event_capacity) {
  counters_.link = LinkState::kConnecting;
}

bool TrackerSession::pop(SourceEvent& event) noexcept {
  if (!events_.pop(event)) return false;
  if (event.kind == SourceEventKind::kFrame) {
    counters_.frames.emitted.add();
    counters_.frames.held.set(held_frames_ + events_.waiting_frames());
  }
  return true;
}

TrackerSession::Described TrackerSession::describe(MarkerSet set) {
  if (!is_rate(set.rate_hz)) set.rate_hz = 0;
  if (options_.mm_per_unit) set.mm_per_unit = *options_.mm_per_unit;
  if (options_.axes) set.axes = *options_.axes;
  const auto known = std::find_if(sets_.begin(), sets_.end(), [&](const MarkerSet& other) {
    set.id = other.id;
    return set == other;
  });
  if (known != sets_.end()) {
    set_ = &*known;
    return Described::kOk;
  }
  set_ = nullptr;
  if (set.names.size() > kMaxMarkers) return Described::kTooManyMarkers;
  if (sets_.size() == kMaxSets) return Described::kTooManySets;
  set.id = static_cast<std::uint32_t>(sets_.size() + 1);
  set_ = &sets_.emplace_back(std::move(set));
  return Described::kOk;
}

void TrackerSession::begin_frame(MarkerFrame& frame) const noexcept {
  frame = {};
  frame.header.stream_id = options_.stream_id;
  frame.header.set_id = set_->id;
  frame.count = static_cast<std::uint32_t>(set_->names.size());
}

void TrackerSession::place(MarkerFrame& frame, std::size_t marker, double x, double y, double z) noexcept {
  // A product with 1 is exact, so that millimetres pass bit for bit.
  const auto to_mm = [this](double value) { return static_cast<float>(set_->mm_per_unit * value); };
  const Position source{to_mm(x), to_mm(y), to_mm(z)};
  if (!is_plausible_position(source.x, source.y, source.z)) {
    frame.reason[marker] = RejectReason::kNotFinite;
    counters_.not_finite_markers.add();
    return;
  }
  frame.state[marker] = MarkerState::kMeasured;
  frame.position_mm[marker] = set_->axes.to_world(source.x, source.y, source.z);
}

void TrackerSession::emit_frame(const MarkerFrame& frame) noexcept {
  if (!open_) {
    open_ = true;
    emitted_set_ = nullptr;
    counters_.sessions.add();
    events_.emit(SourceEventKind::kNewSession, ++session_);
  }
  if (emitted_set_ != set_) {
    emitted_set_ = set_;
    counters_.sets_changed.add();
    events_.emit(SourceEventKind::kMarkerSet, session_).set = set_;
  }
  events_.emit(SourceEventKind::kFrame, session_).frame = frame;
  streamed_ = true;
  counters_.link = LinkState::kStreaming;
  counters_.frames.held.set(held_frames_ + events_.waiting_frames());
}

void TrackerSession::emit_end_of_stream() noexcept {
  if (!open_) return;
  open_ = false;
  events_.emit(SourceEventKind::kEndOfStream, session_);
}

void TrackerSession::set_recording(bool recording) noexcept {
  if (std::exchange(recording_, recording) == recording) return;
  events_.emit(recording ? SourceEventKind::kRecordingStarted : SourceEventKind::kRecordingStopped, session_);
}

void TrackerSession::begin_connection() noexcept {
  failed_ = streamed_ = false;
  outbox_.clear();
}

void TrackerSession::note_link_lost() noexcept {
  counters_.link = streamed_ ? LinkState::kLost : LinkState::kConnecting;
}

void TrackerSession::note_held(std::uint64_t datagrams, std::uint64_t frames) noexcept {
  held_frames_ = frames;
  counters_.datagrams.held.set(datagrams);
  counters_.frames.held.set(held_frames_ + events_.waiting_frames());
}

}  // namespace risorius
