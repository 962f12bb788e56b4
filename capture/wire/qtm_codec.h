// The QTM real-time protocol of Qualisys as pure functions between bytes and values, little-endian, for both sides.
// Specified in capture/README.md. Decoded values are views of the bytes that they were decoded from. Decoding takes any
// bytes, neither allocates nor throws, and believes no size or count beyond the bytes that are there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "capture/frames.h"
#include "capture/wire/byte_appender.h"
#include "capture/wire/packet_status.h"

namespace risorius {

inline constexpr std::size_t kQtmHeaderBytes = 8;

enum class QtmPacketType : std::uint32_t {
  kError = 0,
  kCommand = 1,
  kXml = 2,
  kData = 3,
  kNoMoreData = 4,
  kC3dFile = 5,
  kEvent = 6,
  kDiscover = 7,
  kQtmFile = 8,
};

enum class QtmEvent : std::uint8_t {
  kConnected = 1,
  kConnectionClosed = 2,
  kCaptureStarted = 3,
  kCaptureStopped = 4,
  kFetchingFinished = 5,
  kCalibrationStarted = 6,
  kCalibrationStopped = 7,
  kRtFromFileStarted = 8,
  kRtFromFileStopped = 9,
  kWaitingForTrigger = 10,
  kCameraSettingsChanged = 11,
  kShuttingDown = 12,
  kCaptureSaved = 13,
  kReprocessingStarted = 14,
  kReprocessingStopped = 15,
  kTrigger = 16,
};

/// Component types of a data packet that concern markers.
enum class QtmComponent : std::uint32_t {
  k3d = 1,
  k3dNoLabels = 2,
  k3dResiduals = 9,
  k3dNoLabelsResiduals = 10,
  kTimecode = 17,
};

enum class QtmError : std::uint8_t {
  kNone,
  kTooShort,      ///< ends before its own header does
  kBadSize,       ///< the header's size is below 8, above the limit, or not that of the datagram
  kBadComponent,  ///< a component is shorter than its header or runs past the end of the packet
  kBadCount,      ///< a component has fewer bytes than its count needs
};

struct QtmPacket {
  QtmPacketType type = QtmPacketType::kError;
  std::span<const std::byte> body;  ///< without the header
};

/// Takes one whole packet off the front of `bytes`; otherwise `bytes` is untouched. A packet of more than `max_bytes`
/// is kBad as soon as its header is there.
PacketStatus take_qtm_packet(std::span<const std::byte>& bytes, std::size_t max_bytes, QtmPacket& packet) noexcept;

/// One datagram is one packet.
QtmError read_qtm_datagram(std::span<const std::byte> datagram, QtmPacket& packet) noexcept;

/// The body of an error, command or XML packet, up to its NUL; a missing NUL is tolerated.
std::string_view qtm_text(std::span<const std::byte> body) noexcept;

/// Empty if the body is not one byte that names an event.
std::optional<QtmEvent> qtm_event(std::span<const std::byte> body) noexcept;

/// The markers of one 3D component.
struct QtmMarkers {
  std::size_t count = 0;
  std::uint16_t drop_rate_per_mille = 0;         ///< of 2D data
  std::uint16_t out_of_sync_rate_per_mille = 0;  ///< of 2D data
  std::size_t record_bytes = 0;
  std::span<const std::byte> records;  ///< count * record_bytes; x, y, z as f32 first

  /// Marker i < count; empty where one of its three numbers is no number (all bits set: not seen).
  std::optional<std::array<float, 3>> position(std::size_t i) const noexcept;
};

struct QtmTimecode {
  std::uint32_t type = 0;  ///< 0 SMPTE, 1 IRIG, 2 camera time
  std::uint32_t high = 0;
  std::uint32_t low = 0;

  /// SMPTE at `smpte_rate` frames per second, or IRIG with its tenths of seconds as frames. Empty for camera time and
  /// for fields that no clock shows. The protocol has no drop-frame flag.
  std::optional<Timecode> clock(std::uint8_t smpte_rate) const noexcept;
};

struct QtmData {
  std::uint64_t timestamp_us = 0;
  std::uint32_t frame = 0;
  std::optional<QtmMarkers> labelled, unlabelled;  ///< the first of each kind in the packet
  std::optional<QtmTimecode> timecode;             ///< the first entry
  std::uint32_t other_components = 0;              ///< skipped
};

/// The body of a data packet. By an error `data` has no meaning. Surplus bytes at the end of a component or of the
/// packet, and components of other types, are passed over; a component without a body is as if absent.
QtmError decode_qtm_data(std::span<const std::byte> body, QtmData& data) noexcept;

/// "bad_size" and so on: the name of the error's counter.
std::string_view name_of(QtmError error) noexcept;

// --- the other direction: each appends one whole packet ---

/// For error, command and XML packets.
void append_qtm_text(QtmPacketType type, std::string_view text, ByteAppender& out);
void append_qtm_event(QtmEvent event, ByteAppender& out);
void append_qtm_no_more_data(ByteAppender& out);

/// Which components a data packet gets, as StreamFrames asks for them.
struct QtmComponents {
  bool markers = false, residuals = false, unlabelled = false, unlabelled_residuals = false, timecode = false;
  bool any() const noexcept { return markers || residuals || unlabelled || unlabelled_residuals || timecode; }
};

/// `positions_mm` in the order of the labels, empty entries not seen; there are no unlabelled markers. Without a
/// timecode its component has no entries.
void append_qtm_data(std::uint64_t timestamp_us, std::uint32_t frame, const QtmComponents& components,
                     std::span<const std::optional<std::array<float, 3>>> positions_mm,
                     const std::optional<Timecode>& timecode, ByteAppender& out);

}  // namespace risorius
