// Puts the parts of split marker frames together. A small window of incomplete frames: opening the Nth frame after an
// incomplete one gives that one up, so a lost part loses exactly its frame and holds nothing else up.
//
//   slot = opened % window    [ #8 done | #9 done | #2 half | #3 done | ... ]   opening #10 gives #2 up
//
// Also remembers the last frames that were completed or given up, so that repeated and late parts open no second frame.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/marker_codec.h"

namespace risorius {

class FrameAssembler {
 public:
  /// Closed frames that are remembered.
  static constexpr std::size_t kMemory = 64;

  /// What became of the parts that the assembler held and was handed, and of their frames.
  struct Outcome {
    DecodeError error = DecodeError::kNone;
    std::uint32_t parts_used = 0, parts_dropped = 0, parts_refused = 0;
    std::uint32_t frames_opened = 0, frames_given_up = 0;
    std::uint32_t markers_not_finite = 0;
    const MarkerFrame* complete = nullptr;  ///< valid until the next call
  };

  /// `window` frames, 1 to 64.
  explicit FrameAssembler(std::size_t window);

  /// `set` is the one that the part names, with as many markers as the frame. Sets no stream id and no receive time.
  Outcome add(const MarkerFramePart& part, const MarkerSet& set) noexcept;
  /// Gives up the incomplete frames; of one set, or all.
  Outcome give_up(std::uint32_t set_id) noexcept;
  Outcome give_up_all() noexcept;
  /// give_up_all, and forgets the closed frames.
  Outcome reset() noexcept;

  std::uint32_t held_frames() const noexcept { return held_frames_; }
  std::uint32_t held_parts() const noexcept { return held_parts_; }

 private:
  struct Slot {
    MarkerFrame frame;
    std::bitset<kMaxMarkers> present;
    std::uint32_t parts = 0;  ///< 0: the slot is free
  };
  struct Closed {
    std::uint64_t sequence = 0;
    std::int64_t capture_time_ns = 0;
  };

  bool is_closed(const MarkerFramePart& part) const noexcept;
  Slot* find(const MarkerFramePart& part) noexcept;
  Slot& open(const MarkerFramePart& part, Outcome& outcome) noexcept;
  void give_up(Slot& slot, Outcome& outcome) noexcept;
  void close(Slot& slot) noexcept;

  std::vector<Slot> slots_;
  std::uint64_t opened_ = 0;
  std::array<Closed, kMemory> closed_{};
  std::uint64_t closed_count_ = 0;
  std::uint32_t held_frames_ = 0, held_parts_ = 0;
};

}  // namespace risorius
