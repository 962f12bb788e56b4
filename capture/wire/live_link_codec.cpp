#include "capture/wire/live_link_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "capture/wire/byte_io.h"

namespace risorius {
namespace {

constexpr std::array<std::string_view, kFaceShapes> kShapes{
    "eyeBlinkLeft",      "eyeLookDownLeft",    "eyeLookInLeft",
    "eyeLookOutLeft",    "eyeLookUpLeft",      "eyeSquintLeft",
    "eyeWideLeft",       "eyeBlinkRight",      "eyeLookDownRight",
    "eyeLookInRight",    "eyeLookOutRight",    "eyeLookUpRight",
    "eyeSquintRight",    "eyeWideRight",       "jawForward",
    "jawLeft",           "jawRight",           "jawOpen",
    "mouthClose",        "mouthFunnel",        "mouthPucker",
    "mouthLeft",         "mouthRight",         "mouthSmileLeft",
    "mouthSmileRight",   "mouthFrownLeft",     "mouthFrownRight",
    "mouthDimpleLeft",   "mouthDimpleRight",   "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower",     "mouthRollUpper",
    "mouthShrugLower",   "mouthShrugUpper",    "mouthPressLeft",
    "mouthPressRight",   "mouthLowerDownLeft", "mouthLowerDownRight",
    "mouthUpperUpLeft",  "mouthUpperUpRight",  "browDownLeft",
    "browDownRight",     "browInnerUp",        "browOuterUpLeft",
    "browOuterUpRight",  "cheekPuff",          "cheekSquintLeft",
    "cheekSquintRight",  "noseSneerLeft",      "noseSneerRight",
    "tongueOut"};

constexpr std::array<std::string_view, 6> kErrorNames{"none", "version", "device_id", "name", "truncated", "time"};

constexpr std::uint32_t kVersion = 6;
constexpr double kLowestRateHz = 1, kHighestRateHz = 1000;

std::uint32_t big_endian_u32(ByteReader& in) noexcept {
  const auto value = in.read<std::uint32_t>();
  return __builtin_bswap32(value);
}
std::int32_t big_endian_i32(ByteReader& in) noexcept { return std::bit_cast<std::int32_t>(big_endian_u32(in)); }
float big_endian_f32(ByteReader& in) noexcept { return std::bit_cast<float>(big_endian_u32(in)); }

void append_big_endian(ByteAppender& out, std::uint32_t value) { out.append(__builtin_bswap32(value)); }
void append_big_endian(ByteAppender& out, std::int32_t value) {
  append_big_endian(out, std::bit_cast<std::uint32_t>(value));
}
void append_big_endian(ByteAppender& out, float value) { append_big_endian(out, std::bit_cast<std::uint32_t>(value)); }

std::string_view text_of(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The byte after the version is the '$' of the id: that tells the two forms apart.
bool read_version(ByteReader& in, std::span<const std::byte> datagram, LiveLinkVersionForm& form) noexcept {
  constexpr std::byte kDollar{'$'};
  if (datagram.size() > 1 && datagram[1] == kDollar) {
    form = LiveLinkVersionForm::kByte;
    return in.read<std::uint8_t>() == kVersion;
  }
  form = LiveLinkVersionForm::kU32;
  return in.read<std::uint32_t>() == kVersion && in.ok();
}

bool is_time(const LiveLinkPacket& packet) noexcept {
  if (packet.frame < 0 || packet.fps <= 0 || packet.denominator <= 0) return false;
  if (!(std::abs(packet.subframe) <= 1)) return false;
  return packet.rate_hz() >= kLowestRateHz && packet.rate_hz() <= kHighestRateHz;
}

}  // namespace

std::span<const std::string_view, kFaceShapes> live_link_shape_names() noexcept { return kShapes; }
std::span<const std::string_view> live_link_error_names() noexcept { return kErrorNames; }

LiveLinkError decode_live_link(std::span<const std::byte> datagram, LiveLinkPacket& packet) noexcept {
  ByteReader in(datagram);
  packet = LiveLinkPacket{};
  if (!read_version(in, datagram, packet.form)) return LiveLinkError::kNotSix;
  packet.device_id = text_of(in.take(kLiveLinkIdBytes));
  if (!in.ok()) return LiveLinkError::kTruncated;
  if (packet.device_id.front() != '$') return LiveLinkError::kId;
  const std::int32_t name_bytes = big_endian_i32(in);
  if (!in.ok()) return LiveLinkError::kTruncated;
  if (name_bytes < 0 || name_bytes > static_cast<std::int32_t>(kMaxLiveLinkNameBytes)) return LiveLinkError::kName;
  packet.name = text_of(in.take(static_cast<std::size_t>(name_bytes)));
  packet.frame = big_endian_i32(in);
  packet.subframe = big_endian_f32(in);
  packet.fps = big_endian_i32(in);
  packet.denominator = big_endian_i32(in);
  if (!in.ok()) return LiveLinkError::kTruncated;
  if (packet.denominator == 0) packet.denominator = 1;  // senders that know whole rates only
  if (!is_time(packet)) return LiveLinkError::kTime;
  if (in.remaining() == 0) return LiveLinkError::kNone;

  const std::size_t count = in.read<std::uint8_t>();
  if (in.remaining() < 4 * count) return LiveLinkError::kTruncated;
  packet.has_face = count > 0;
  for (std::size_t i = 0; i < kLiveLinkValues; ++i) {
    const float value = i < count ? big_endian_f32(in) : ShapeFrame::kNone;
    packet.value[i] = std::isfinite(value) ? value : ShapeFrame::kNone;
  }
  return LiveLinkError::kNone;
}

void encode_live_link(const LiveLinkPacket& packet, ByteAppender& out) {
  if (packet.form == LiveLinkVersionForm::kByte) {
    out.append(static_cast<std::uint8_t>(kVersion));
  } else {
    out.append(kVersion);
  }
  std::array<char, kLiveLinkIdBytes> id;
  id.fill('0');
  id[0] = '$';
  std::copy_n(packet.device_id.data(), std::min(packet.device_id.size(), id.size()), id.data());
  out.append_text({id.data(), id.size()});
  const std::string_view name = packet.name.substr(0, kMaxLiveLinkNameBytes);
  append_big_endian(out, static_cast<std::int32_t>(name.size()));
  out.append_text(name);
  append_big_endian(out, packet.frame);
  append_big_endian(out, packet.subframe);
  append_big_endian(out, packet.fps);
  append_big_endian(out, packet.denominator);
  if (!packet.has_face) return;
  out.append(static_cast<std::uint8_t>(kLiveLinkValues));
  for (const float value : packet.value) append_big_endian(out, value);
}

}  // namespace risorius
