// The client's side of a NatNet connection without its sockets: datagrams in, events and datagrams out, time by Ticks.
//
//   connecting --SERVERINFO--> asking the rate --> asking the model --MODELDEF--> streaming
//       ^ CONNECT in its three forms in turn, waits doubled to the longest           | silence, DISCONNECT
//       '----------------------------------------------------------------------------'
//
// While streaming: keep-alives, echoes for the clock, a new definition when the server says that its models changed,
// and the version again when the server says so or a frame shows it. One thread; allocates for definitions, never for
// frames.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/event_ring.h"
#include "capture/wire/natnet_codec.h"
#include "capture/wire/natnet_marker_map.h"
#include "capture/wire/source.h"

namespace risorius {

struct NatnetOptions {
  std::uint32_t stream_id = 0;      ///< written into every frame
  double mm_per_unit = 1000;        ///< of the server's numbers, which are metres; finite, > 0
  Axes axes;                        ///< of the server's numbers; LUF: Y up, the subject looks along +Z
  std::string markers;              ///< NatnetMarkerMap::build
  std::uint8_t timecode_rate = 30;  ///< frames per second of the timecode, which NatNet does not tell; 1 to 60
  bool timecode_drop_frame = false;
  std::size_t event_capacity = 256;          ///< events that wait for pop, 8 to 65536
  std::int64_t first_wait_ns = 250'000'000;  ///< for an answer, before the next try
  std::int64_t longest_wait_ns = 5'000'000'000;
  std::int64_t silence_ns = 1'000'000'000;     ///< without any datagram of the server: it is lost
  std::int64_t keep_alive_ns = 1'000'000'000;  ///< between keep-alives
  std::int64_t echo_ns = 250'000'000;          ///< between echo requests
};

class NatnetSession {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit NatnetSession(const NatnetOptions& options);

  /// Is there room for the events of one datagram?
  bool ready() const noexcept { return events_.ready(kMaxEventsPerDatagram); }
  std::size_t datagrams_until_full() const noexcept { return events_.room() / kMaxEventsPerDatagram; }
  /// A datagram from the server's address. False if not ready: nothing was consumed.
  bool push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept;
  /// A datagram from anybody else.
  void push_foreign() noexcept;
  /// Does what is due; the first one begins to connect. To be called at next_tick_ns() at the latest.
  void tick(Tick tick) noexcept;
  std::int64_t next_tick_ns() const noexcept;
  /// The next datagram to the server's command port; false if there is none.
  bool pop_datagram(NatnetDatagram& datagram);

  bool pop(SourceEvent& event) noexcept;
  void flush() noexcept {}
  /// False if there is no new one. Samples that nobody takes are overwritten.
  bool pop_clock_sample(ClockSample& sample) noexcept;

  /// Empty before the server has answered.
  const std::optional<NatnetServerInfo>& server() const noexcept { return server_; }
  SourceCounters& counters() noexcept { return counters_; }
  const SourceCounters& counters() const noexcept { return counters_; }

 private:
  enum class Phase : std::uint8_t { kConnecting, kAskingRate, kAskingModel, kStreaming };
  static constexpr std::size_t kMaxEventsPerDatagram = 6;  ///< recording and stream end, session, set, recording, frame
  static constexpr std::size_t kMaxOutgoing = 8;
  static constexpr std::size_t kMaxSets = 4096;

  NatnetError take(const NatnetPacket& packet, std::int64_t now_ns);
  NatnetError take_server_info(std::span<const std::byte> payload, std::int64_t now_ns);
  NatnetError take_response(std::span<const std::byte> payload, std::int64_t now_ns);
  NatnetError take_model(std::span<const std::byte> payload, std::int64_t now_ns);
  NatnetError take_frame(std::span<const std::byte> payload, std::int64_t now_ns);
  NatnetError take_echo(std::span<const std::byte> payload, std::int64_t now_ns);
  NatnetError begin_or_change(std::int64_t now_ns);
  bool goes_back(std::int32_t frame_number, std::int64_t now_ns) const noexcept;
  void watch(const NatnetFrame& frame, bool restarted, std::int64_t now_ns);
  void begin_session(std::int64_t now_ns) noexcept;
  void use(const MarkerSet* set) noexcept;
  void follow_restart(std::int64_t now_ns) noexcept;
  bool capture_time(const NatnetSuffix& suffix, std::int64_t& time_ns) const noexcept;
  Timecode timecode(const NatnetSuffix& suffix) noexcept;
  const MarkerSet* store(const std::vector<std::string>& names);
  NatnetDatagram* outgoing() noexcept;
  void send(NatnetMessage message);
  void send_connect();
  void enter(Phase phase, std::int64_t now_ns) noexcept;
  void connect_again(std::int64_t now_ns) noexcept;
  void retry(std::int64_t now_ns);
  void ask_again(std::int64_t now_ns);
  void keep_up(std::int64_t now_ns);
  std::int64_t longest_pause_ns() const noexcept;
  void lose() noexcept;
  std::int64_t longest_silence_ns() const noexcept;
  void end_stream() noexcept;

  NatnetOptions options_;
  Phase phase_ = Phase::kConnecting;
  std::size_t connect_form_ = 0;
  bool masked_request_ = false;  ///< the form of the last request for models
  std::int64_t wait_ns_ = 0, retry_at_ns_ = INT64_MIN;
  std::int64_t heard_ns_ = INT64_MIN, framed_ns_ = INT64_MIN, keep_alive_at_ns_ = INT64_MIN, echo_at_ns_ = INT64_MIN;
  std::int64_t connected_ns_ = INT64_MIN, ask_again_at_ns_ = INT64_MIN;
  std::int64_t began_ns_ = INT64_MIN;           ///< the session
  std::int64_t changing_until_ns_ = INT64_MIN;  ///< frames before that are of models that we do not know
  std::int64_t asked_version_ns_ = INT64_MIN;
  bool models_changed_bit_ = false, bitstream_changed_bit_ = false;
  std::optional<NatnetServerInfo> server_;
  double rate_hz_ = 0;
  std::uint32_t session_ = 0;
  bool stream_open_ = false, recording_ = false;
  std::int32_t last_frame_number_ = 0;

  NatnetMarkerMap map_;
  const MarkerSet* set_ = nullptr;                ///< in force; null before the first definition of the session
  std::vector<std::unique_ptr<MarkerSet>> sets_;  ///< all that ever were: frames downstream point at them
  EventRing events_;
  std::array<NatnetDatagram, kMaxOutgoing> outgoing_;
  std::size_t first_outgoing_ = 0, outgoing_count_ = 0;
  std::uint64_t echo_ticks_ = 0;  ///< of the request that is on its way; 0: none
  std::optional<ClockSample> clock_sample_;
  SourceCounters counters_;
  Counter impossible_timecodes_;
  std::array<SourceExtra, 1> extras_;
};

}  // namespace risorius
