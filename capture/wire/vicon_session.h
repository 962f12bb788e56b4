// A client's side of the Vicon DataStream protocol: bytes in -> marker sets, frames, and requests to send. Packets may
// come in any order; the server pushes. A marker without a record is occluded, unless the server says that the records
// are as before. Capture times are the frame's number at the server's rate: the protocol has no clock.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/wire/tracker_session.h"
#include "capture/wire/vicon_codec.h"
#include "capture/wire/vicon_names.h"

namespace risorius {

enum class ViconRefusal : std::uint8_t {
  kBadTag,
  kTooLong,
  kBadObject,
  kBadLength,
  kBadNames,        ///< a subject that cannot be decoded
  kNoNames,         ///< a frame before the markers' names are known, or without the subject that is wanted
  kNoMarkers,       ///< a frame without labelled records
  kTooManyMarkers,  ///< more names than a frame holds, kMaxMarkers
  kTooManySets,     ///< TrackerSession::kMaxSets
};

struct ViconCounters {
  Counter unlabelled_markers;  ///< seen, but of no use for AUs: without names, or with ids that nobody described
  Counter latency_us;          ///< the server's own, of the last frame: from exposure to sending
  Counter round_trip_us;       ///< of the last Ping
  Counter arrival_times;       ///< frames with their arrival for a capture time, because the server states no rate
};

/// On CLOCK_MONOTONIC; the server's clock is not in it.
struct ViconPing {
  std::int64_t sent_ns = 0, received_ns = 0;
};

struct ViconSessionOptions {
  TrackerSessionOptions tracker;
  std::string subject;  ///< the one to take; "": all
  double rate_hz = 0;   ///< where the server states none; 0: arrival times
};

class ViconSession : public TrackerSession {
 public:
  /// The longest packet that is believed.
  static constexpr std::size_t kMaxPacketBytes = (1 << 20) - kViconHeaderBytes;

  /// Throws UserError naming the option.
  explicit ViconSession(const ViconSessionOptions& options);

  void connected(std::int64_t now_ns) override;
  void disconnected() override;
  std::size_t receive(std::span<const std::byte> bytes, std::int64_t receive_time_ns) override;
  // Frames come over the connection only.
  void use_udp_port(std::uint16_t) override {}
  void receive_datagram(std::span<const std::byte>, std::int64_t) override {}
  void tick(std::int64_t now_ns) override;
  void flush() noexcept override {}

  const ViconCounters& vicon_counters() const noexcept { return vicon_; }
  /// The newest Ping that was answered.
  std::optional<ViconPing> last_ping() const noexcept { return last_ping_; }

 private:
  /// What one packet says.
  struct Contents {
    std::optional<std::uint32_t> frame;
    std::optional<ViconRecons> labelled, unlabelled;
    std::optional<ViconTimecode> timecode;
    std::optional<double> latency_s;
    std::optional<std::int64_t> period;
    std::optional<std::uint8_t> y_up;
    std::optional<ViconIds> offered;
    std::optional<std::int64_t> ping;
    ViconIds unchanged;
  };

  ViconError read(std::span<const std::byte> objects, Contents& contents);
  bool read_object(const ViconObject& object, Contents& contents);
  void take(std::span<const std::byte> objects, std::int64_t time_ns);
  std::optional<ViconRefusal> update_set(const Contents& contents);
  void answer_offer(ViconIds offered);
  void take_ping(std::int64_t id, std::int64_t time_ns) noexcept;
  void take_frame(const Contents& contents, std::int64_t time_ns);
  void place_records(const Contents& contents);
  std::int64_t capture_time_of(std::uint32_t frame, std::int64_t receive_time_ns) noexcept;
  double rate_hz() const noexcept;
  void send_ping(std::int64_t now_ns);

  double assumed_rate_hz_;
  ViconNames names_;
  std::optional<ViconRefusal> set_refusal_;  ///< why the subjects that were described last are no set
  ViconCounters vicon_;
  std::array<SourceExtra, 4> extras_;
  std::vector<std::span<const std::byte>> subjects_;  ///< of the packet being read
  std::vector<std::uint32_t> asked_ids_;
  std::int64_t period_ = 0;  ///< ticks of 135 MHz per frame; 0 not stated
  bool y_up_ = false;
  MarkerFrame frame_;
  std::optional<std::uint32_t> last_frame_;
  bool have_records_ = false;  ///< frame_ has the records of the last frame, by the names in force

  bool greeted_ = false;
  std::int64_t connected_ns_ = 0, heard_ns_ = 0;
  std::int64_t ping_id_ = 0, ping_sent_ns_ = 0;
  bool ping_answered_ = false;
  std::optional<ViconPing> last_ping_;
};

}  // namespace risorius
