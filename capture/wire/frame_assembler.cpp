#include "capture/wire/frame_assembler.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

bool is_of(const MarkerFrame& frame, const MarkerFramePart& part) noexcept {
  // The capture time is part of it: a sender that starts over sends the same sequences at other times.
  return frame.header.sequence == part.sequence && frame.header.capture_time_ns == part.capture_time_ns &&
         frame.header.set_id == part.set_id && frame.count == part.count;
}

}  // namespace

FrameAssembler::FrameAssembler(std::size_t window) {
  if (window < 1 || window > kMemory) {
    throw std::invalid_argument(fmt::format("reassembly window of {} frames is not within 1 to {}", window, kMemory));
  }
  slots_.resize(window);
}

bool FrameAssembler::is_closed(const MarkerFramePart& part) const noexcept {
  const auto end = closed_.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(closed_count_, kMemory));
  return std::any_of(closed_.begin(), end, [&part](const Closed& closed) {
    return closed.sequence == part.sequence && closed.capture_time_ns == part.capture_time_ns;
  });
}

FrameAssembler::Slot* FrameAssembler::find(const MarkerFramePart& part) noexcept {
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [&part](const Slot& slot) { return slot.parts > 0 && is_of(slot.frame, part); });
  return found == slots_.end() ? nullptr : &*found;
}

void FrameAssembler::close(Slot& slot) noexcept {
  closed_[closed_count_++ % kMemory] = {slot.frame.header.sequence, slot.frame.header.capture_time_ns};
  held_parts_ -= slot.parts;
  --held_frames_;
  slot.parts = 0;
  slot.present.reset();
}

void FrameAssembler::give_up(Slot& slot, Outcome& outcome) noexcept {
  outcome.parts_dropped += slot.parts;
  ++outcome.frames_given_up;
  close(slot);
}

FrameAssembler::Slot& FrameAssembler::open(const MarkerFramePart& part, Outcome& outcome) noexcept {
  Slot& slot = slots_[opened_++ % slots_.size()];
  if (slot.parts > 0) give_up(slot, outcome);
  slot.frame = MarkerFrame{};
  slot.frame.header.set_id = part.set_id;
  slot.frame.header.sequence = part.sequence;
  slot.frame.header.capture_time_ns = part.capture_time_ns;
  slot.frame.header.timecode = part.timecode;
  slot.frame.count = static_cast<std::uint32_t>(part.count);
  ++outcome.frames_opened;
  ++held_frames_;
  return slot;
}

FrameAssembler::Outcome FrameAssembler::add(const MarkerFramePart& part, const MarkerSet& set) noexcept {
  Outcome outcome;
  if (is_closed(part)) {
    outcome.parts_dropped = 1;
    return outcome;
  }
  Slot* slot = find(part);
  if (slot != nullptr) {
    std::size_t overlap = 0;
    for (std::size_t i = part.first; i < part.first + part.part_count; ++i) overlap += slot->present[i] ? 1 : 0;
    if (overlap == part.part_count) {
      outcome.parts_dropped = 1;
      return outcome;
    }
    if (overlap != 0) {
      outcome.error = DecodeError::kInconsistentPart;
      outcome.parts_refused = 1;
      return outcome;
    }
  } else {
    slot = &open(part, outcome);
  }
  outcome.markers_not_finite = static_cast<std::uint32_t>(place_markers(part, set.mm_per_unit, set.axes, slot->frame));
  for (std::size_t i = part.first; i < part.first + part.part_count; ++i) slot->present.set(i);
  ++slot->parts;
  ++held_parts_;
  if (slot->present.count() == part.count) {
    outcome.parts_used = slot->parts;
    outcome.complete = &slot->frame;
    close(*slot);
  }
  return outcome;
}

FrameAssembler::Outcome FrameAssembler::give_up(std::uint32_t set_id) noexcept {
  Outcome outcome;
  for (Slot& slot : slots_) {
    if (slot.parts > 0 && slot.frame.header.set_id == set_id) give_up(slot, outcome);
  }
  return outcome;
}

FrameAssembler::Outcome FrameAssembler::give_up_all() noexcept {
  Outcome outcome;
  for (Slot& slot : slots_) {
    if (slot.parts > 0) give_up(slot, outcome);
  }
  return outcome;
}

FrameAssembler::Outcome FrameAssembler::reset() noexcept {
  const Outcome outcome = give_up_all();
  closed_count_ = 0;
  return outcome;
}

}  // namespace risorius
