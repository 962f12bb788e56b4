// One side of a conversation with a tracker, without sockets: bytes in -> events and bytes to send, time by Ticks. The
// base holds what all trackers share: events, counters, which marker set is in force, when a session begins and ends.
// Runs on one thread; counters may be read from any. Invariant: each frame event comes after the event of the marker
// set that it names, within the same session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "capture/marker_set.h"
#include "capture/wire/byte_appender.h"
#include "capture/wire/event_ring.h"
#include "capture/wire/source.h"

namespace risorius {

struct TrackerSessionOptions {
  std::uint32_t stream_id = 0;        ///< written into every frame
  std::optional<double> mm_per_unit;  ///< overrides millimetres; finite, > 0
  std::optional<Axes> axes;           ///< overrides what the tracker states or its protocol says
  std::size_t event_capacity = 256;   ///< events that wait for pop, 16 to 65536
};

class TrackerSession {
 public:
  static constexpr std::size_t kMaxSets = 4096;  ///< distinct marker sets of one session object; more are refused

  virtual ~TrackerSession() = default;

  /// A new connection: nothing has been said on it.
  virtual void connected(std::int64_t now_ns) = 0;
  /// The connection is gone: ends what was going on.
  virtual void disconnected() = 0;
  /// The next bytes of the connection. Returns how many of them were used; the rest is to be given again, with more.
  virtual std::size_t receive(std::span<const std::byte> bytes, std::int64_t receive_time_ns) = 0;
  /// Where datagrams are received; 0 (the beginning): frames over the connection. For the connections to come.
  virtual void use_udp_port(std::uint16_t port) = 0;
  /// A datagram of the tracker, where frames come over UDP.
  virtual void receive_datagram(std::span<const std::byte> datagram, std::int64_t receive_time_ns) = 0;
  /// Time passes; at least every 100 ms, and every 5 ms while frames are held.
  virtual void tick(std::int64_t now_ns) = 0;
  /// Gives up everything incomplete.
  virtual void flush() noexcept = 0;

  /// Whether the connection is of no use any more and should be made anew.
  bool failed() const noexcept { return failed_; }
  /// To be sent over the connection; the sender clears it.
  ByteAppender& outbox() noexcept { return outbox_; }
  /// For the events of how many packets is there room?
  std::size_t room_for_packets() const noexcept {
    return events_.room() < kMaxEventsAtTheEnd ? 0 : (events_.room() - kMaxEventsAtTheEnd) / kMaxEventsPerPacket;
  }
  bool ready() const noexcept { return room_for_packets() > 0; }
  bool pop(SourceEvent& event) noexcept;

  SourceCounters& counters() noexcept { return counters_; }
  const SourceCounters& counters() const noexcept { return counters_; }

 protected:
  static constexpr std::size_t kMaxEventsPerPacket = 6;  ///< two frames, each with a session and set; or a recording
  static constexpr std::size_t kMaxEventsAtTheEnd = 2;

  /// Throws UserError naming the option, its value and range.
  TrackerSession(const TrackerSessionOptions& options, std::span<const std::string_view> reasons);

  const TrackerSessionOptions& options() const noexcept { return options_; }
  enum class Described : std::uint8_t { kOk, kTooManyMarkers, kTooManySets };
  /// The set of the frames to come, with names as TrackerNames makes them. A rate that is none is not stated.
  Described describe(MarkerSet set);
  void forget_set() noexcept { set_ = nullptr; }
  /// Null before a set is described.
  const MarkerSet* set() const noexcept { return set_; }
  /// An empty frame of the set in force.
  void begin_frame(MarkerFrame& frame) const noexcept;
  /// The position in the tracker's numbers; not finite: missing, counted.
  void place(MarkerFrame& frame, std::size_t marker, double x, double y, double z) noexcept;
  /// Emits the frame, after session and set if they are new. The frame was counted as received.
  void emit_frame(const MarkerFrame& frame) noexcept;
  /// The next frame begins a new session.
  void end_session() noexcept { open_ = false; }
  /// The tracker says that its stream ends; nothing if it had not begun.
  void emit_end_of_stream() noexcept;
  void set_recording(bool recording) noexcept;
  void fail() noexcept { failed_ = true; }
  void begin_connection() noexcept;
  /// kLost if frames have come over this connection, else kConnecting.
  void note_link_lost() noexcept;
  /// For the ledgers: parts and frames that are neither emitted nor given up.
  void note_held(std::uint64_t datagrams, std::uint64_t frames) noexcept;

 private:
  TrackerSessionOptions options_;
  SourceCounters counters_;
  EventRing events_;
  ByteAppender outbox_;
  std::deque<MarkerSet> sets_;  ///< they never move
  const MarkerSet* set_ = nullptr;
  const MarkerSet* emitted_set_ = nullptr;  ///< in this session
  std::uint32_t session_ = 0;
  std::uint64_t held_frames_ = 0;
  bool open_ = false, recording_ = false, failed_ = false, streamed_ = false;
};

}  // namespace risorius
