// What a [[source]] is to the daemon, whatever its protocol: something on the I/O thread that turns what comes over its
// socket into SourceEvents. It calls the `on_ready` that its constructor was given when there is something to pop. A
// consumer that leaves it full pauses it until resume(). Invariant: each frame event comes after the event of the
// marker set that it names, within the same session.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "capture/counters.h"
#include "capture/wire/raw_tap.h"
#include "capture/wire/source_event.h"

namespace risorius {

/// kListening: no connection is needed, and nothing has come. kConnecting: asking the tracker. kWaiting: the tracker
/// has answered, no frames yet. kStreaming: frames come. kLost: they came, and come no more.
enum class LinkState : std::uint8_t { kListening, kConnecting, kWaiting, kStreaming, kLost };

/// "listening" and so on.
std::string_view name_of(LinkState state) noexcept;

/// A counter that only one protocol has.
struct SourceExtra {
  std::string_view name;  ///< static
  const Counter* counter = nullptr;
};

/// One writing thread, read by any.
struct SourceCounters {
  static constexpr std::size_t kMaxReasons = 32;

  /// `names`: one for each reason of refusal; static, at most kMaxReasons.
  explicit SourceCounters(std::span<const std::string_view> names) noexcept : reasons(names) {}

  /// Datagrams, messages or packets. emitted: used for something; dropped: repeated, late, or of a frame or set given
  /// up as incomplete; refused: by `refused`.
  StageLedger datagrams;
  /// received: one of its parts was accepted; dropped: incomplete. A frame refused with its datagrams is not in here.
  StageLedger frames;
  Counter incomplete_frames;   ///< given up because a part was lost
  Counter not_finite_markers;  ///< flagged valid, but no number or more than a kilometre away; handed on as missing
  Counter sessions;
  Counter sets_changed;

  Counter kernel_drops;  ///< datagrams that found the receive buffer full (SO_RXQ_OVFL), known with the next datagram
  Counter granted_buffer_bytes;  ///< SO_RCVBUF as the kernel gave it; below what was asked if net.core.rmem_max forbids
  Counter truncated;             ///< longer than any message by far; refused as well
  Counter receive_errors;        ///< of the socket
  Counter refused_connections;   ///< ZeroMQ with CURVE: without the right key
  Counter foreign;               ///< datagrams from another host than the tracker; not looked at
  Counter wake_ups;
  Counter rests;       ///< UDP: turns that brought only what is of no use, so that the source had to wait for the next
  Counter pauses;      ///< the consumer left the source full
  Counter reconnects;  ///< the connection was lost and made again

  std::atomic<LinkState> link{LinkState::kListening};

  std::span<const std::string_view> reasons;
  std::array<Counter, kMaxReasons> refused;  ///< datagrams, by reason

  std::span<const SourceExtra> extras;  ///< set before any other thread reads

  template <class Reason>
  void refuse(Reason reason, std::uint64_t count = 1) noexcept {
    datagrams.refused.add(count);
    refused[static_cast<std::size_t>(reason)].add(count);
  }
  template <class Reason>
  std::uint64_t of(Reason reason) const noexcept {
    return refused[static_cast<std::size_t>(reason)].value();
  }
};

/// One answered echo: the tracker's clock, read between two times of ours.
struct ClockSample {
  std::int64_t sent_ns = 0;      ///< CLOCK_MONOTONIC
  std::int64_t tracker_ns = 0;   ///< the clock that capture times are read from
  std::int64_t received_ns = 0;  ///< CLOCK_MONOTONIC
};

class Source {
 public:
  virtual ~Source() = default;

  /// Before start(): hands every datagram, message or piece of a connection's packets to the tap as it is received.
  virtual void tap_raw(const RawTap& tap) noexcept = 0;
  virtual void start() = 0;
  /// Closes the sockets; on_ready is not called any more. Final.
  virtual void stop() noexcept = 0;
  /// After a pause: there is room for events again.
  virtual void resume() = 0;
  /// False if no event waits.
  virtual bool pop(SourceEvent& event) noexcept = 0;
  /// Gives up everything incomplete; what is complete can still be popped.
  virtual void flush() noexcept = 0;
  /// Whether the transport keeps the order of frames, so that a gap in their sequence is final.
  virtual bool keeps_order() const noexcept { return false; }
  /// As a URL: where senders can send (with the port that the system chose), or what we are connected to.
  virtual std::string endpoint() const = 0;
  virtual const SourceCounters& counters() const noexcept = 0;
  /// For protocols with an echo. False if there is no new sample; one that nobody takes is overwritten by the next.
  virtual bool pop_clock_sample(ClockSample&) noexcept { return false; }

 protected:
  Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;
};

}  // namespace risorius
