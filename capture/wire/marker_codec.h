// The native protocol of marker streams as pure functions between bytes and values; specified in capture/README.md.
// The same bytes are one UDP datagram or one ZeroMQ message. Numbers on the wire are in the sender's unit and axes:
// encoding writes a frame's numbers as they are, `place_markers` turns decoded ones into mm and LUF axes.
// Decoded parts are views: they live as long as the bytes that they were decoded from. Nothing here allocates or
// throws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/source_event.h"

namespace risorius {

/// 1500 bytes of Ethernet less 28 of IP and UDP headers: a datagram that is never fragmented.
inline constexpr std::size_t kMaxDatagramBytes = 1472;
inline constexpr std::size_t kMaxMarkersPerDatagram = 117;
inline constexpr std::uint16_t kProtocolVersion = 1;

/// Why a datagram is of no use. The first group is about its bytes alone, the second about what came before it.
enum class DecodeError : std::uint8_t {
  kNone,
  kTooShort,
  kTooLong,
  kBadMagic,
  kBadVersion,
  kBadChecksum,
  kBadType,
  kBadLength,  ///< shorter or longer than its own counts say
  kBadCount,   ///< no markers, more than kMaxMarkers, or a part outside of the whole
  kBadValue,   ///< a rate, unit, axis letter, flag or name that cannot be

  kUnknownSet,        ///< a frame before its marker set, or of a set never described
  kOtherSession,      ///< a frame or end of a run that is not the one being received
  kCountMismatch,     ///< the frame and its marker set have different numbers of markers
  kInconsistentPart,  ///< a part that overlaps other parts of its frame or marker set without repeating them
  kBadSet,            ///< a complete marker set that names a marker twice
  kTooManySets,
};
inline constexpr std::size_t kDecodeErrorCount = static_cast<std::size_t>(DecodeError::kTooManySets) + 1;

/// "bad_checksum" and so on: the name of the error's counter.
std::string_view name_of(DecodeError error) noexcept;
/// All of them, in the order of the enumeration.
std::span<const std::string_view> decode_error_names() noexcept;

/// Names [first, first + part_count) of a marker set.
struct MarkerSetPart {
  std::uint32_t session = 0;
  std::uint32_t set_id = 0;
  std::uint16_t revision = 0;
  double rate_hz = 0;
  double mm_per_unit = 1;
  Axes axes;
  std::size_t count = 0;
  std::size_t first = 0;
  std::size_t part_count = 0;
  std::span<const std::byte> names;  ///< part_count times (u8 size, bytes), checked
};

/// Takes the next name off `names`, which must not be empty.
std::string_view take_name(std::span<const std::byte>& names) noexcept;

/// Markers [first, first + part_count) of a frame.
struct MarkerFramePart {
  std::uint32_t session = 0;
  std::uint32_t set_id = 0;
  std::uint64_t sequence = 0;
  std::int64_t capture_time_ns = 0;
  Timecode timecode;
  std::size_t count = 0;
  std::size_t first = 0;
  std::size_t part_count = 0;
  std::span<const std::byte> valid_bits;
  std::span<const std::byte> positions;  ///< part_count times 3 float32, sender's unit and axes
};

/// Writes the part's markers into `frame` in mm and LUF axes, rounded to float once. A marker that is flagged valid but
/// is not finite becomes missing with reason kNotFinite. Returns the number of those.
std::size_t place_markers(const MarkerFramePart& part, double mm_per_unit, const Axes& axes,
                          MarkerFrame& frame) noexcept;

using NativeMessage = std::variant<EndOfStream, MarkerFramePart, MarkerSetPart>;

/// Any bytes, of any length, give a message or an error of the first group; `message` is untouched by an error.
DecodeError decode(std::span<const std::byte> datagram, NativeMessage& message) noexcept;

using DatagramBuffer = std::array<std::byte, kMaxDatagramBytes>;

/// Bytes written, and the marker that the next part starts with (the count, when this part was the last).
struct EncodedPart {
  std::size_t bytes = 0;
  std::size_t next = 0;
};

/// The part of the set that starts with name `first` < names.size(); as many names as fit. The set has no problems_of.
/// `revision` tells definitions under one id apart.
EncodedPart encode(const MarkerSet& set, std::uint32_t session, std::uint16_t revision, std::size_t first,
                   DatagramBuffer& out) noexcept;

/// The part of the frame that starts with marker `first` < frame.count. Only measured markers are sent as valid.
EncodedPart encode(const MarkerFrame& frame, std::uint32_t session, std::size_t first, DatagramBuffer& out) noexcept;

/// Returns the number of bytes.
std::size_t encode(const EndOfStream& end, DatagramBuffer& out) noexcept;

}  // namespace risorius
