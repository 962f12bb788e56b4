// Puts frames (of markers, or of face shapes) back into the order of their sequence. In-order frames pass without
// delay; frames after a gap wait until the gap closes, `depth` of them wait, or Ticks say that `timeout_ns` has passed
// since the first Tick that saw the gap.
//
//   frames_  [ released, in the order of pop | waiting behind a gap, by sequence ]     released_ divides the two
//
// Invariants: popped sequences rise within a stream; received = emitted + dropped + refused + held at any time; and
// next_sequence - first sequence of the stream = released + lost + late arrivals that had been counted as lost.
// Time enters only as Ticks; receive times are not read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "capture/counters.h"
#include "capture/frames.h"
#include "capture/shape_frame.h"
#include "capture/stage.h"

namespace risorius {

struct ReorderOptions {
  std::size_t depth = 8;                    ///< frames that may wait behind a gap, 1 to 64
  std::int64_t timeout_ns = 20'000'000;     ///< the longest wait, in the time of Ticks, > 0
  std::uint64_t restart_back_frames = 512;  ///< a sequence this far behind is a new stream; > depth, at most 65536
  std::uint64_t restart_forward_frames = 100000;  ///< a sequence this far ahead is a new stream; > depth
};

/// What a window counts, whatever its frames are.
class ReorderCounters {
 public:
  const StageLedger& ledger() const noexcept { return ledger_; }
  /// Never received, as far as is known. A frame that arrives after it was counted here is taken out again.
  const Counter& lost() const noexcept { return lost_; }
  const Counter& duplicates() const noexcept { return duplicates_; }  ///< dropped
  const Counter& late() const noexcept { return late_; }              ///< dropped; came after their place was given up
  const Counter& restarts() const noexcept { return restarts_; }

 protected:
  StageLedger ledger_;
  Counter lost_, duplicates_, late_, restarts_;
};

/// `Frame`: MarkerFrame or ShapeFrame.
template <class Frame>
class ReorderWindowOf : public ReorderCounters {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit ReorderWindowOf(const ReorderOptions& options = {});

  /// False if `depth` frames are inside and must be popped first.
  bool push(const Frame& frame) noexcept;
  bool pop(Frame& frame) noexcept;
  /// Of the clock that receive times are read from; of this window's stream.
  void tick(Tick tick) noexcept;
  /// The transport keeps the order: what is missing now will not come, so nothing waits for it.
  void give_up_gaps() noexcept;
  /// Releases everything; the next frame starts a stream with whatever sequence it has.
  void flush() noexcept;
  /// The sender has said that `last_sequence` was its last: releases everything and counts what is missing up to there.
  /// A frame of before that still comes is late or a duplicate; one of after it starts a stream.
  void end_of_stream(std::uint64_t last_sequence) noexcept;

 private:
  enum class Fate : std::uint8_t { kBeforeStream, kReleased, kLost };

  std::size_t waiting() const noexcept { return frame_count_ - released_; }
  Frame& at(std::size_t i) noexcept { return slots_[order_[i]]; }
  Fate& fate_of(std::uint64_t sequence) noexcept { return fates_[sequence & (fates_.size() - 1)]; }
  Fate fate_of(std::uint64_t sequence) const noexcept { return fates_[sequence & (fates_.size() - 1)]; }
  bool is_restart(const Frame& frame, std::int64_t ahead) const noexcept;
  void start(std::uint64_t sequence) noexcept;
  void drop_behind(const Frame& frame) noexcept;
  void insert(const Frame& frame) noexcept;
  void release_in_order() noexcept;
  void lose_until(std::uint64_t sequence) noexcept;
  void give_up_gap() noexcept;
  void release_all() noexcept;

  ReorderOptions options_;
  std::vector<Frame> slots_;
  std::vector<std::uint32_t> order_;  ///< [0, frame_count_) slots in use as drawn above, then the free ones
  std::size_t frame_count_ = 0;
  std::size_t released_ = 0;

  bool started_ = false;
  bool ended_ = false;                       ///< the end was announced, and nothing has come that goes on
  std::uint64_t next_sequence_ = 0;          ///< wraps around as the sender's does
  std::int64_t newest_capture_time_ns_ = 0;  ///< of this stream's frames that were released, or came too late
  std::vector<Fate> fates_;                  ///< of the last sequences before next_sequence_; size a power of two
  std::optional<std::int64_t> gap_seen_ns_;  ///< the first Tick that saw the gap
};

extern template class ReorderWindowOf<MarkerFrame>;
extern template class ReorderWindowOf<ShapeFrame>;
using ReorderWindow = ReorderWindowOf<MarkerFrame>;

static_assert(Stage<ReorderWindow, MarkerFrame, MarkerFrame>);

}  // namespace risorius
