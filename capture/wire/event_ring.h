// The elastic buffer between a source and its consumer: a ring of SourceEvents with a declared depth. The source asks
// for room before it reads on; so the ring never overflows, and what does not fit waits in the kernel. One thread;
// allocates in the constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture/counters.h"
#include "capture/wire/source_event.h"

namespace risorius {

class EventRing {
 public:
  /// Throws UserError if `depth` is not 3 to 65536 events.
  explicit EventRing(std::size_t depth);

  std::size_t depth() const noexcept { return events_.size(); }
  std::size_t size() const noexcept { return count_; }
  std::size_t room() const noexcept { return events_.size() - count_; }
  bool ready(std::size_t events) const noexcept { return room() >= events; }
  /// Frame events that wait.
  std::uint64_t waiting_frames() const noexcept { return waiting_frames_; }
  /// The most events that ever waited.
  const Counter& high_water() const noexcept { return high_water_; }

  /// The next event, for the caller to fill in: its frame and recording name are those of an earlier one. Needs room.
  SourceEvent& emit(SourceEventKind kind, std::uint32_t session) noexcept;
  /// False if no event waits.
  bool pop(SourceEvent& event) noexcept;

 private:
  std::vector<SourceEvent> events_;
  std::size_t first_ = 0, count_ = 0;
  std::uint64_t waiting_frames_ = 0;
  Counter high_water_;
};

}  // namespace risorius
