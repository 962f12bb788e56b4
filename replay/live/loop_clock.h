// A take that is played in a loop goes on counting: sequence and capture time of a later round follow those of the
// round before.
#pragma once

#include <cstdint>

#include "capture/frames.h"

namespace risorius {

class LoopClock {
 public:
  /// Moves the frame's sequence and capture time into its round.
  void place(MarkerFrame& frame) noexcept {
    frame.header.sequence += sequence_offset_;
    frame.header.capture_time_ns += time_offset_ns_;
    last_sequence_ = frame.header.sequence;
    last_time_ns_ = frame.header.capture_time_ns;
  }
  /// `frame_ns`: between the last frame and the first of the next round.
  void begin_round(std::int64_t frame_ns) noexcept {
    sequence_offset_ = last_sequence_ + 1;
    time_offset_ns_ = last_time_ns_ + frame_ns;
  }

 private:
  std::uint64_t sequence_offset_ = 0, last_sequence_ = 0;
  std::int64_t time_offset_ns_ = 0, last_time_ns_ = 0;
};

}  // namespace risorius
