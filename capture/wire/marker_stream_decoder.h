// Native datagrams -> events of one stream: sessions, marker sets, whole frames, ends. Runs where datagrams are
// received. Bad data never throws; every datagram and every frame ends in exactly one account of its ledger. Invariant:
// each frame event comes after the event of the marker set that it names, within the same session. One thread pushes
// and pops; any thread may read the counters. Allocates only when a new marker set is described.
//
// Two senders on one port do not take it from each other: the session being received keeps it until it says its end or
// is silent for kSessionHoldNs. Until then everything of others is refused, but their marker sets are remembered, so
// that a sender that was killed and started again goes on with its first frame after the hold.
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
  std::size_t event_capacity = 256;   ///< events that wait for pop, 3 to 65536
};

class MarkerStreamDecoder {
 public:
  /// How long a session may be silent before another one may take its place.
  static constexpr std::int64_t kSessionHoldNs = 250'000'000;

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
  static constexpr std::size_t kMaxEventsPerDatagram = 3;  ///< a session, its set, a frame

  SourceEvent& emit(SourceEventKind kind) noexcept { return events_.emit(kind, living_->session().value_or(0)); }
  void take(const MarkerSetPart& part, std::int64_t receive_time_ns) noexcept;
  void take(const MarkerFramePart& part, std::int64_t receive_time_ns) noexcept;
  void take(const EndOfStream& end) noexcept;
  void begin_session() noexcept;
  bool is_over(std::int64_t now_ns) const noexcept;
  /// The rival that described `set_id` becomes the session being received; false if that is not `session`.
  bool take_over(std::uint32_t session, std::uint32_t set_id) noexcept;
  void account(const FrameAssembler::Outcome& outcome) noexcept;
  void update_held() noexcept;

  std::uint32_t stream_id_;
  MarkerSetBook first_book_, second_book_;  ///< both stay for good: frames downstream point at their sets
  MarkerSetBook* living_ = &first_book_;    ///< of the session being received
  MarkerSetBook* rival_ = &second_book_;    ///< of the last other session that described sets meanwhile
  std::int64_t last_heard_ns_ = 0;          ///< of the session being received
  FrameAssembler assembler_;
  std::optional<EndOfStream> last_end_;  ///< of this session, if it has not gone on; senders repeat it

  EventRing events_;
  SourceCounters counters_;
};

}  // namespace risorius
