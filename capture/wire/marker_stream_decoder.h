// Native datagrams -> events of one stream: sessions, marker sets, whole frames, ends. Runs where datagrams are
// received. Bad data never throws; every datagram and every frame ends in exactly one account of its ledger. Invariant:
// each frame event comes after the event of the marker set that it names, within the same session. One thread pushes
// and pops; any thread may read the counters. Allocates only when a new marker set is described.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/event_ring.h"
#include "capture/wire/frame_assembler.h"
#include "capture/wire/marker_codec.h"
#include "capture/wire/marker_set_book.h"
#include "capture/wire/source.h"

namespace risorius {

struct DecoderOptions {
  std::uint32_t stream_id = 0;        ///< written into every frame
  std::optional<double> mm_per_unit;  ///< overrides what the sender states; finite, > 0
  std::optional<Axes> axes;           ///< overrides what the sender states
  std::size_t reassembly_frames = 8;  ///< window of incomplete frames, 1 to 64
  std::size_t event_capacity = 256;   ///< events that wait for pop, 2 to 65536
};

class MarkerStreamDecoder {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit MarkerStreamDecoder(const DecoderOptions& options = {});

  /// Is there room for the events of one datagram?
  bool ready() const noexcept { return events_.ready(kMaxEventsPerDatagram); }
  /// How many datagrams can be pushed without a pop in between.
  std::size_t datagrams_until_full() const noexcept { return events_.room() / kMaxEventsPerDatagram; }
  /// False if not ready: nothing was consumed. `receive_time_ns`: CLOCK_MONOTONIC right after the receive call.
  bool push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept;
  /// False if no event waits.
  bool pop(SourceEvent& event) noexcept;
  /// Gives up everything incomplete; what is complete can still be popped.
  void flush() noexcept;

  /// Refusals by DecodeError. The source that feeds the decoder adds what only it can know.
  SourceCounters& counters() noexcept { return counters_; }
  const SourceCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::size_t kMaxEventsPerDatagram = 2;  ///< a session and its first set

  SourceEvent& emit(SourceEventKind kind) noexcept { return events_.emit(kind, sets_.session().value_or(0)); }
  void take(const MarkerSetPart& part) noexcept;
  void take(const MarkerFramePart& part, std::int64_t receive_time_ns) noexcept;
  void take(const EndOfStream& end) noexcept;
  void account(const FrameAssembler::Outcome& outcome) noexcept;
  void update_held() noexcept;

  std::uint32_t stream_id_;
  MarkerSetBook sets_;
  FrameAssembler assembler_;
  std::optional<EndOfStream> last_end_;  ///< of this session; senders repeat it, because datagrams get lost

  EventRing events_;
  SourceCounters counters_;
};

}  // namespace risorius
