// What one Live Link Face device sends -> events: sessions, a set without names that states the rate, frames of face
// shapes. Capture time and sequence come from the frame time in the packets (frames since midnight), never from
// arrivals:
//   sequence      the first frame's own number in a session; then one more for each frame time that fits between a
//   frame
//                 and the newest, rounded. So a device whose rate is not quite the one that it states loses no frame.
//   midnight      the count goes on; the drop-frame count of 29.97 and 59.94 frames/s too.
//   new session   the frame time leaps back by more than half a second or ahead by more than ten, and a second packet
//                 goes on from there (the first is refused): a straggler alone ends nothing. Or the rate changes.
// Bad data never throws. One thread pushes and pops; any thread may read the counters.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "capture/marker_set.h"
#include "capture/wire/event_ring.h"
#include "capture/wire/live_link_codec.h"
#include "capture/wire/source.h"

namespace risorius {

struct LiveLinkOptions {
  std::uint32_t stream_id = 0;       ///< written into every frame
  std::string device;                ///< the one to take; "" = the first that comes
  double rate_hz = 0;                ///< of frames; 0 = as the packets say, which some devices count in a finer base
  std::size_t event_capacity = 256;  ///< events that wait for pop, 3 to 65536
};

/// Beyond LiveLinkError's: kOtherDevice: not ours. kLeap: the frame time leapt. kRates: the rate changed too often.
enum class LiveLinkRefusal : std::uint8_t { kOtherDevice = 6, kLeap, kRates };

class LiveLinkSession {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit LiveLinkSession(const LiveLinkOptions& options = {});
  LiveLinkSession(const LiveLinkSession&) = delete;
  LiveLinkSession& operator=(const LiveLinkSession&) = delete;

  /// Is there room for the events of one datagram?
  bool ready() const noexcept { return events_.ready(kMaxEventsPerDatagram); }
  std::size_t datagrams_until_full() const noexcept { return events_.room() / kMaxEventsPerDatagram; }
  /// False if not ready: nothing was consumed. `receive_time_ns`: CLOCK_MONOTONIC right after the receive call.
  /// Allocates only where a rate is new.
  bool push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept;
  /// False if no event waits.
  bool pop(SourceEvent& event) noexcept;
  /// Nothing is ever incomplete here.
  void flush() noexcept {}

  SourceCounters& counters() noexcept { return counters_; }
  const SourceCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::size_t kMaxEventsPerDatagram = 3;  ///< a session, its set and a frame
  static constexpr std::size_t kMaxRates = 64;

  bool is_ours(std::string_view name);
  bool goes_on(double time) const noexcept;
  double on_from_midnight(double time, const LiveLinkPacket& packet) noexcept;
  bool begin_session(const LiveLinkPacket& packet, double time);
  const MarkerSet* set_of(double rate_hz);
  std::uint64_t number(double time) noexcept;
  void emit_frame(const LiveLinkPacket& packet, double time, std::int64_t receive_time_ns) noexcept;

  LiveLinkOptions options_;
  std::string device_;  ///< whom we listen to
  bool has_device_;

  // Times are in frames of the packets' base.
  bool started_ = false;
  std::int32_t fps_ = 0, denominator_ = 0;
  double rate_hz_ = 0;    ///< of the base
  double step_ = 1;       ///< between two frames
  double midnights_ = 0;  ///< frames of the days before
  double newest_ = 0;     ///< the newest frame's time
  std::uint64_t newest_sequence_ = 0;
  std::optional<double> leapt_to_;  ///< of a packet that leapt; the next may go on from there
  std::uint32_t session_ = 0;
  const MarkerSet* set_ = nullptr;
  std::deque<MarkerSet> sets_;

  EventRing events_;
  SourceCounters counters_;
  Counter frames_without_face_, values_unusable_;
  std::array<SourceExtra, 2> extras_;
};

/// The timecode of frame `frame` since midnight; `frame_rate` 0 (none) for rates above 255 frames/s. Unreal's
/// rule: 29.97 and 59.94 frames/s are drop-frame.
Timecode live_link_timecode(std::int32_t frame, std::int32_t fps, std::int32_t denominator) noexcept;

}  // namespace risorius
