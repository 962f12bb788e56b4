#include "capture/wire/event_ring.h"

#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"

namespace risorius {
namespace {

bool is_frame(SourceEventKind kind) noexcept {
  return kind == SourceEventKind::kFrame || kind == SourceEventKind::kShapes;
}

std::size_t checked(std::size_t depth) {
  if (depth < 3 || depth > 65536) {
    throw UserError("event_capacity", fmt::format("{} is out of range", depth), "3 to 65536");
  }
  return depth;
}

}  // namespace

EventRing::EventRing(std::size_t depth) : events_(checked(depth)) {}

SourceEvent& EventRing::emit(SourceEventKind kind, std::uint32_t session) noexcept {
  RISORIUS_CHECK(count_ < events_.size());
  SourceEvent& event = events_[(first_ + count_++) % events_.size()];
  event.kind = kind;
  event.session = session;
  event.set = nullptr;
  event.end = {};
  event.recording_name_size = 0;
  if (is_frame(kind)) ++waiting_frames_;
  high_water_.raise_to(count_);
  return event;
}

bool EventRing::pop(SourceEvent& event) noexcept {
  if (count_ == 0) return false;
  event = events_[first_];
  first_ = (first_ + 1) % events_.size();
  --count_;
  if (is_frame(event.kind)) --waiting_frames_;
  return true;
}

}  // namespace risorius
