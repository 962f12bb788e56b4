#include "capture/wire/reorder_window.h"

#include <algorithm>
#include <bit>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "capture/errors.h"

namespace risorius {
namespace {

void require(bool ok, const char* option, auto value, const char* range) {
  if (!ok) throw UserError(option, fmt::format("{} is out of range", value), range);
}

/// How far `sequence` lies ahead of `next`, right across the end of the numbers too.
std::int64_t distance(std::uint64_t sequence, std::uint64_t next) noexcept {
  return static_cast<std::int64_t>(sequence - next);
}

}  // namespace

template <class Frame>
ReorderWindowOf<Frame>::ReorderWindowOf(const ReorderOptions& options) : options_(options) {
  constexpr auto kMaxForward = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  require(options.depth >= 1 && options.depth <= 64, "depth", options.depth, "1 to 64 frames");
  require(options.timeout_ns > 0, "timeout_ns", options.timeout_ns, "more than 0 ns");
  require(options.restart_back_frames > options.depth && options.restart_back_frames <= 65536, "restart_back_frames",
          options.restart_back_frames, "more than depth, at most 65536 frames");
  require(options.restart_forward_frames > options.depth && options.restart_forward_frames <= kMaxForward,
          "restart_forward_frames", options.restart_forward_frames, "more than depth, at most 2^63 - 1 frames");
  slots_.resize(options.depth);
  order_.resize(options.depth);
  std::iota(order_.begin(), order_.end(), 0u);
  fates_.resize(std::bit_ceil(static_cast<std::size_t>(options.restart_back_frames)));
}

template <class Frame>
bool ReorderWindowOf<Frame>::is_restart(const Frame& frame, std::int64_t ahead) const noexcept {
  if (ahead >= 0) return static_cast<std::uint64_t>(ahead) > options_.restart_forward_frames;
  if (0 - static_cast<std::uint64_t>(ahead) > options_.restart_back_frames) return true;
  // The sequence goes back and time goes on: the sender has started over, soon after it started. Not so where the end
  // of the stream was announced and counted as lost: there a late frame is newer than all that were released.
  return frame.header.capture_time_ns > newest_capture_time_ns_ && fate_of(frame.header.sequence) != Fate::kLost;
}

template <class Frame>
void ReorderWindowOf<Frame>::start(std::uint64_t sequence) noexcept {
  started_ = true;
  ended_ = false;
  next_sequence_ = sequence;
  newest_capture_time_ns_ = std::numeric_limits<std::int64_t>::min();
  std::fill(fates_.begin(), fates_.end(), Fate::kBeforeStream);
  gap_seen_ns_.reset();
}

template <class Frame>
void ReorderWindowOf<Frame>::drop_behind(const Frame& frame) noexcept {
  ledger_.dropped.add();
  Fate& fate = fate_of(frame.header.sequence);
  if (fate == Fate::kReleased) {
    duplicates_.add();
    return;
  }
  late_.add();
  if (fate == Fate::kLost) lost_.set(lost_.value() - 1);
  fate = Fate::kReleased;  // received, though not used: another copy is a duplicate
  newest_capture_time_ns_ = std::max(newest_capture_time_ns_, frame.header.capture_time_ns);
}

template <class Frame>
void ReorderWindowOf<Frame>::insert(const Frame& frame) noexcept {
  const std::int64_t ahead = distance(frame.header.sequence, next_sequence_);
  const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(released_);
  const auto end = order_.begin() + static_cast<std::ptrdiff_t>(frame_count_);
  const auto place = std::find_if(
      begin, end, [&](std::uint32_t slot) { return distance(slots_[slot].header.sequence, next_sequence_) >= ahead; });
  if (place != end && slots_[*place].header.sequence == frame.header.sequence) {
    ledger_.dropped.add();
    duplicates_.add();
    return;
  }
  slots_[*end] = frame;
  std::rotate(place, end, end + 1);
  ++frame_count_;
}

template <class Frame>
void ReorderWindowOf<Frame>::release_in_order() noexcept {
  while (waiting() > 0 && at(released_).header.sequence == next_sequence_) {
    newest_capture_time_ns_ = std::max(newest_capture_time_ns_, at(released_).header.capture_time_ns);
    fate_of(next_sequence_++) = Fate::kReleased;
    ++released_;
    gap_seen_ns_.reset();
  }
}

template <class Frame>
void ReorderWindowOf<Frame>::lose_until(std::uint64_t sequence) noexcept {
  const std::uint64_t gap = sequence - next_sequence_;
  lost_.add(gap);
  for (std::uint64_t back = 1; back <= std::min<std::uint64_t>(gap, fates_.size()); ++back) {
    fate_of(sequence - back) = Fate::kLost;
  }
  next_sequence_ = sequence;
}

template <class Frame>
void ReorderWindowOf<Frame>::give_up_gap() noexcept {
  lose_until(at(released_).header.sequence);
  release_in_order();
}

template <class Frame>
void ReorderWindowOf<Frame>::release_all() noexcept {
  while (waiting() > 0) give_up_gap();
  gap_seen_ns_.reset();
}

template <class Frame>
bool ReorderWindowOf<Frame>::push(const Frame& frame) noexcept {
  if (frame_count_ == options_.depth) return false;
  ledger_.received.add();
  const std::uint64_t sequence = frame.header.sequence;
  if (!started_) start(sequence);
  std::int64_t ahead = distance(sequence, next_sequence_);
  if (ended_ && (ahead >= 0 || is_restart(frame, ahead))) {
    start(sequence);
    ahead = 0;
  } else if (is_restart(frame, ahead)) {
    release_all();
    start(sequence);
    restarts_.add();
    ahead = 0;
  }
  if (ahead < 0) {
    drop_behind(frame);
    return true;
  }
  insert(frame);
  release_in_order();
  if (waiting() == options_.depth) give_up_gap();
  ledger_.held.set(frame_count_);
  return true;
}

template <class Frame>
bool ReorderWindowOf<Frame>::pop(Frame& frame) noexcept {
  if (released_ == 0) return false;
  frame = at(0);
  std::rotate(order_.begin(), order_.begin() + 1, order_.begin() + static_cast<std::ptrdiff_t>(frame_count_));
  --frame_count_;
  --released_;
  ledger_.emitted.add();
  ledger_.held.set(frame_count_);
  return true;
}

template <class Frame>
void ReorderWindowOf<Frame>::tick(Tick tick) noexcept {
  if (waiting() == 0) return;
  if (!gap_seen_ns_) {
    gap_seen_ns_ = tick.time_ns;
  } else if (tick.time_ns - *gap_seen_ns_ >= options_.timeout_ns) {
    gap_seen_ns_.reset();
    give_up_gap();
  }
}

template <class Frame>
void ReorderWindowOf<Frame>::give_up_gaps() noexcept {
  if (waiting() > 0) release_all();
}

template <class Frame>
void ReorderWindowOf<Frame>::flush() noexcept {
  release_all();
  started_ = false;
}

template <class Frame>
void ReorderWindowOf<Frame>::end_of_stream(std::uint64_t last_sequence) noexcept {
  release_all();
  const std::int64_t missing = started_ ? distance(last_sequence + 1, next_sequence_) : 0;
  if (missing > 0 && static_cast<std::uint64_t>(missing) <= options_.restart_forward_frames) {
    lose_until(last_sequence + 1);
  }
  ended_ = started_;
}

template class ReorderWindowOf<MarkerFrame>;
template class ReorderWindowOf<ShapeFrame>;

}  // namespace risorius
