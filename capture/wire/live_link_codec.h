// The packets of Live Link Face (UDP, version 6), both ways; pure functions on bytes. Numbers are big-endian but for
// the version. Layout, and what public readings of it disagree about: capture/README.md, "Live Link Face".
//
//   | version | '$' + uuid, 37 bytes | i32 n | name, n bytes | i32 frame | f32 subframe | i32 fps | i32 denominator |
//   | u8 m | m x f32 |      without a face: nothing after the denominator, or m = 0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "capture/shape_frame.h"
#include "capture/wire/byte_appender.h"

namespace risorius {

/// 52 shapes, then yaw, pitch and roll (radians) of head, left eye and right eye.
inline constexpr std::size_t kLiveLinkValues = kFaceShapes + 9;
inline constexpr std::size_t kLiveLinkIdBytes = 37;
inline constexpr std::size_t kMaxLiveLinkNameBytes = 255;

/// ARKit's names ("eyeBlinkLeft") in the order of the packets, which is Unreal's: jawLeft and mouthLeft before the
/// right ones. The app's CSV files have them the other way round.
std::span<const std::string_view, kFaceShapes> live_link_shape_names() noexcept;

enum class LiveLinkVersionForm : std::uint8_t { kU32, kByte };

struct LiveLinkPacket {
  LiveLinkVersionForm form = LiveLinkVersionForm::kU32;
  std::string_view device_id;  ///< with its '$'; 37 bytes
  std::string_view name;       ///< the device's, as the app is told it: "subject"
  std::int32_t frame = 0;      ///< since midnight, at fps / denominator
  float subframe = 0;          ///< what part of a frame later
  std::int32_t fps = 60, denominator = 1;
  bool has_face = false;
  std::array<float, kLiveLinkValues> value{};  ///< NaN where the packet has fewer, or no finite number

  double rate_hz() const noexcept { return static_cast<double>(fps) / denominator; }
};

enum class LiveLinkError : std::uint8_t { kNone, kNotSix, kId, kName, kTruncated, kTime };
/// "version" and so on, by LiveLinkError. kNotSix: another version, or no such packet at all.
std::span<const std::string_view> live_link_error_names() noexcept;

/// Views in `packet` look at `datagram`. Surplus values, and bytes behind the last value, are skipped. kTime: fps and
/// denominator are not above 0, or make a rate beyond 1 to 1000 Hz; frame below 0, or subframe not within -1 to 1.
LiveLinkError decode_live_link(std::span<const std::byte> datagram, LiveLinkPacket& packet) noexcept;

/// Appends one packet. `device_id` is cut to, or filled up to, its 37 bytes; a longer name is cut.
void encode_live_link(const LiveLinkPacket& packet, ByteAppender& out);

}  // namespace risorius
