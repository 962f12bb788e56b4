// Native datagrams -> events of one stream: sessions, marker sets, whole frames, ends. Runs where datagrams are
// received. Bad data never throws; every datagram and every frame ends in exactly one account of its ledger. Invariant:
// each frame event comes after the event of the marker set that it names, within the same session. One thread pushes
// and pops; any thread may read the counters. Allocates only when a new marker set is described.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/counters.h"
#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/frame_assembler.h"
#include "capture/wire/marker_codec.h"
#include "capture/wire/marker_set_book.h"

namespace risorius {

enum class SourceEventKind : std::uint8_t { kNewSession, kMarkerSet, kFrame, kEndOfStream };

struct SourceEvent {
  SourceEventKind kind = SourceEventKind::kFrame;
  std::uint32_t session = 0;
  const MarkerSet* set = nullptr;  ///< kMarkerSet: unchanging, lives as long as the decoder
  EndOfStream end;                 ///< kEndOfStream
  MarkerFrame frame;               ///< kFrame
};

struct DecoderOptions {
  std::uint32_t stream_id = 0;        ///< written into every frame
  std::optional<double> mm_per_unit;  ///< overrides what the sender states; finite, > 0
  std::optional<Axes> axes;           ///< overrides what the sender states
  std::size_t reassembly_frames = 8;  ///< window of incomplete frames, 1 to 64
  std::size_t event_capacity = 256;   ///< events that wait for pop, 2 to 65536
};

struct DecoderCounters {
  /// used for a frame, set, session or end; dropped: repeated, late, or of a frame or set given up as incomplete.
  StageLedger datagrams;
  /// received: one of its parts was accepted; dropped: incomplete. A frame refused with its datagrams is not in here.
  StageLedger frames;
  Counter incomplete_frames;   ///< given up because a part was lost
  Counter not_finite_markers;  ///< flagged valid, but no position; handed on as missing
  Counter sessions;
  Counter sets_changed;
  std::array<Counter, kDecodeErrorCount> errors;  ///< refused datagrams, by DecodeError

  std::uint64_t of(DecodeError error) const noexcept { return errors[static_cast<std::size_t>(error)].value(); }
};

class MarkerStreamDecoder {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit MarkerStreamDecoder(const DecoderOptions& options = {});

  /// Is there room for the events of one datagram?
  bool ready() const noexcept { return free_events() >= kMaxEventsPerDatagram; }
  /// How many datagrams can be pushed without a pop in between.
  std::size_t datagrams_until_full() const noexcept { return free_events() / kMaxEventsPerDatagram; }
  /// False if not ready: nothing was consumed. `receive_time_ns`: CLOCK_MONOTONIC right after the receive call.
  bool push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept;
  /// False if no event waits.
  bool pop(SourceEvent& event) noexcept;
  /// Gives up everything incomplete; what is complete can still be popped.
  void flush() noexcept;

  const DecoderCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::size_t kMaxEventsPerDatagram = 2;  ///< a session and its first set

  std::size_t free_events() const noexcept { return events_.size() - event_count_; }
  SourceEvent& emit(SourceEventKind kind) noexcept;
  void refuse(DecodeError error, std::uint64_t datagrams = 1) noexcept;
  void take(const MarkerSetPart& part) noexcept;
  void take(const MarkerFramePart& part, std::int64_t receive_time_ns) noexcept;
  void take(const EndOfStream& end) noexcept;
  void account(const FrameAssembler::Outcome& outcome) noexcept;
  void update_held() noexcept;

  std::uint32_t stream_id_;
  MarkerSetBook sets_;
  FrameAssembler assembler_;
  std::optional<EndOfStream> last_end_;  ///< of this session; senders repeat it, because datagrams get lost

  std::vector<SourceEvent> events_;  ///< ring
  std::size_t first_event_ = 0, event_count_ = 0;
  std::uint64_t waiting_frames_ = 0;  ///< frame events in the ring
  DecoderCounters counters_;
};

}  // namespace risorius
