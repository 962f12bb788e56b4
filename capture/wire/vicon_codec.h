// The Vicon DataStream protocol as pure functions between bytes and values, little-endian: the reading side
// (vicon_packet_writer.h is the other). Specified in capture/README.md. A packet is a row of objects; each kind of
// object has its own decoder. Decoded values are views of the bytes that they were decoded from, except subjects, whose
// names are copied. Decoding takes any bytes, does not throw, and believes no length or count beyond the bytes that are
// there; surplus bytes at an object's end are passed over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frames.h"
#include "capture/wire/packet_status.h"

namespace risorius {

inline constexpr std::uint32_t kViconTag = 0x1A2B0001;
inline constexpr std::size_t kViconHeaderBytes = 8;  ///< of a packet and of an object; never counted in their lengths
inline constexpr std::uint32_t kViconNoFrame = 0xFFFFFFFF;

enum class ViconId : std::uint32_t {
  kStreamInfo = 1,
  kSubjectInfo = 2,
  kFrameInfo = 5,
  kLabeledRecons = 6,
  kUnlabeledRecons = 7,
  kTimecode = 23,
  kLatencyInfo = 26,
  kApplicationInfo = 37,
  kFrameRateInfo = 39,
  kPing = 42,
  kObjectEnums = 100001,
  kRequestFrame = 100002,
  kKeepAlive = 100003,
  kContents = 100004,
  kStartMulticastSender = 100005,
  kStopMulticastSender = 100006,
  kFilter = 100007,
  kRequestNextFrame = 100008,
};

enum class ViconError : std::uint8_t {
  kNone,
  kTooShort,   ///< a datagram that ends before its own header or length does
  kBadTag,     ///< does not begin with the protocol's tag
  kTooLong,    ///< the declared length is above the limit
  kBadObject,  ///< an object runs past the end of its packet
  kBadLength,  ///< an object is shorter than its kind or its counts need
};

/// "bad_tag" and so on: the name of the error's counter.
std::string_view name_of(ViconError error) noexcept;

/// Takes one whole packet off the front of `bytes` and gives its objects; otherwise `bytes` is untouched. kBad: a wrong
/// tag (known after four bytes) or a length above `max_bytes`, told apart by `error`.
PacketStatus take_vicon_packet(std::span<const std::byte>& bytes, std::size_t max_bytes,
                               std::span<const std::byte>& objects, ViconError& error) noexcept;

struct ViconObject {
  std::uint32_t id = 0;
  std::span<const std::byte> body;
};

/// Takes the next object off the front of `objects`, which must not be empty. False if it runs past the end.
bool take_vicon_object(std::span<const std::byte>& objects, ViconObject& object) noexcept;

/// A vector or set of u32 in a packet.
class ViconIds {
 public:
  ViconIds() = default;
  explicit ViconIds(std::span<const std::byte> ids) : ids_(ids) {}
  std::size_t size() const noexcept { return ids_.size() / 4; }
  bool contains(std::uint32_t id) const noexcept;

 private:
  std::span<const std::byte> ids_;
};

struct ViconMarkerName {
  std::uint32_t id = 0;
  std::string name;
};

struct ViconSubject {
  std::uint32_t id = 0;
  std::string name;
  std::vector<ViconMarkerName> markers;
};

/// SMPTE timecode as the SDK knows it.
struct ViconTimecode {
  std::uint8_t hours = 0, minutes = 0, seconds = 0, frames = 0;
  std::uint32_t standard = 0xFFFFFFFF;  ///< 0 PAL, 1 NTSC, 2 NTSC drop, 3 film, 4 NTSC film, 5 ATSC, else none

  /// Empty without a standard and for fields that no clock shows.
  std::optional<Timecode> clock() const noexcept;
};

/// One labelled or unlabelled reconstruction.
struct ViconRecon {
  std::uint32_t subject = 0, marker = 0;  ///< 0 in unlabelled ones
  std::array<double, 3> position_mm{};
};

/// Records of LabeledRecons (116 bytes) or UnlabeledRecons (108 bytes).
struct ViconRecons {
  std::size_t count = 0;
  bool labelled = true;
  std::span<const std::byte> records;
  ViconRecon operator[](std::size_t i) const noexcept;
};

/// How many of each kind the packet has (not read) and which kinds are as they were before.
struct ViconContents {
  ViconIds unchanged;
};

std::optional<ViconIds> decode_vicon_ids(std::span<const std::byte> body) noexcept;
std::optional<ViconContents> decode_vicon_contents(std::span<const std::byte> body) noexcept;
std::optional<ViconSubject> decode_vicon_subject(std::span<const std::byte> body);
std::optional<ViconTimecode> decode_vicon_timecode(std::span<const std::byte> body) noexcept;
std::optional<ViconRecons> decode_vicon_recons(std::span<const std::byte> body, bool labelled) noexcept;
/// LatencyInfo: the sum of its entries in seconds.
std::optional<double> decode_vicon_latency_s(std::span<const std::byte> body) noexcept;
/// StreamInfo: ticks of 135 MHz per frame; Ping: any number.
std::optional<std::int64_t> decode_vicon_i64(std::span<const std::byte> body) noexcept;
/// FrameInfo and RequestNextFrame.
std::optional<std::uint32_t> decode_vicon_u32(std::span<const std::byte> body) noexcept;
/// RequestFrame (1 push, 0 pull) and ApplicationInfo (1 Y-up, 0 Z-up).
std::optional<std::uint8_t> decode_vicon_u8(std::span<const std::byte> body) noexcept;

inline constexpr double kViconTicksPerSecond = 135e6;

}  // namespace risorius
