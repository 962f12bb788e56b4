// A client's side of the QTM real-time protocol: bytes in -> marker sets, frames, recordings, and commands to send.
// Frames whose components come in several packets with the same frame number are put together: a frame is complete
// when it has all components that the last ones had, and given on at the latest when another begins or 20 ms have
// passed. Capture times are QTM's time stamps.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/wire/qtm_codec.h"
#include "capture/wire/qtm_dialog.h"
#include "capture/wire/tracker_session.h"

namespace risorius {

enum class QtmRefusal : std::uint8_t {
  kTooShort,
  kBadSize,
  kBadComponent,
  kBadCount,
  kBadType,         ///< a packet or event of no known kind
  kBadSettings,     ///< settings that are no XML
  kErrorReply,      ///< QTM refused a command
  kNoLabels,        ///< a frame before the labels are known
  kCountMismatch,   ///< a frame with other than the labels' number of markers
  kBadTime,         ///< a time stamp that no clock reaches
  kNoMarkers,       ///< settings without a label that begins with the prefix
  kTooManyMarkers,  ///< more such labels than a frame holds, kMaxMarkers
  kTooManySets,     ///< TrackerSession::kMaxSets
};

struct QtmSessionOptions {
  TrackerSessionOptions tracker;
  std::string label_prefix;  ///< only labels that begin so are markers, named by the rest; "": all
};

struct QtmCounters {
  Counter unlabelled_markers;          ///< seen, but of no use for AUs
  Counter drop_rate_per_mille;         ///< of 2D data, the last frame's
  Counter out_of_sync_rate_per_mille;  ///< of 2D data, the last frame's
};

class QtmSession : public TrackerSession {
 public:
  /// The longest packet that is believed.
  static constexpr std::size_t kMaxPacketBytes = 1 << 20;

  /// Throws UserError naming the option.
  explicit QtmSession(const QtmSessionOptions& options);

  void connected(std::int64_t now_ns) override;
  void disconnected() override;
  std::size_t receive(std::span<const std::byte> bytes, std::int64_t receive_time_ns) override;
  void use_udp_port(std::uint16_t port) override { udp_port_ = port; }
  void receive_datagram(std::span<const std::byte> datagram, std::int64_t receive_time_ns) override;
  void tick(std::int64_t now_ns) override;
  void flush() noexcept override;

  const QtmCounters& qtm_counters() const noexcept { return qtm_; }
  const QtmDialog& dialog() const noexcept { return dialog_; }

 private:
  /// The parts of a frame that have come.
  struct Pending {
    bool active = false;
    std::uint32_t frame = 0;
    std::uint8_t parts = 0;  ///< bits of kMarkersPart and so on
    std::uint64_t packets = 0;
    std::int64_t begun_ns = 0;
    MarkerFrame markers;
  };

  void take(const QtmPacket& packet, std::int64_t time_ns);
  void take_event(std::span<const std::byte> body, std::int64_t time_ns);
  void take_settings(std::span<const std::byte> body, std::int64_t time_ns);
  void take_data(std::span<const std::byte> body, std::int64_t time_ns);
  void open_pending(const QtmData& data, std::int64_t time_ns);
  void add_parts(const QtmData& data);
  void finish_pending() noexcept;
  void give_up_pending() noexcept;
  std::optional<QtmRefusal> refusal_of(const QtmData& data) const noexcept;
  void end_stream() noexcept;
  std::optional<QtmRefusal> update_set();
  void check_dialog() noexcept;
  void used() noexcept { counters().datagrams.emitted.add(); }

  QtmDialog dialog_;
  QtmCounters qtm_;
  std::array<SourceExtra, 3> extras_;
  std::uint16_t udp_port_ = 0;
  Pending pending_;
  std::uint8_t expected_parts_ = 0;
  std::string label_prefix_;
  std::size_t labels_ = 0;                 ///< that a frame has
  std::optional<QtmRefusal> set_refusal_;  ///< why the labels that came last are no set
  std::vector<std::size_t> labelled_;      ///< of each marker of the set, its place among the labels
  bool any_finished_ = false;
  std::uint32_t finished_frame_ = 0;  ///< the last one
};

}  // namespace risorius
