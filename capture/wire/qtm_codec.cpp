#include "capture/wire/qtm_codec.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "capture/wire/byte_io.h"

namespace risorius {
namespace {

constexpr std::uint32_t kSmpte = 0, kIrig = 1;
constexpr std::uint32_t kNotSeenBits = 0xFFFFFFFF;

std::size_t record_bytes_of(QtmComponent type) noexcept {
  switch (type) {
    case QtmComponent::k3d:
      return 12;
    case QtmComponent::k3dNoLabels:
    case QtmComponent::k3dResiduals:
      return 16;
    case QtmComponent::k3dNoLabelsResiduals:
      return 20;
    default:
      return 0;
  }
}

QtmError read_markers(QtmComponent type, ByteReader in, std::optional<QtmMarkers>& into) noexcept {
  QtmMarkers markers;
  markers.count = in.read<std::uint32_t>();
  markers.drop_rate_per_mille = in.read<std::uint16_t>();
  markers.out_of_sync_rate_per_mille = in.read<std::uint16_t>();
  markers.record_bytes = record_bytes_of(type);
  if (!in.ok() || markers.count > in.remaining() / markers.record_bytes) return QtmError::kBadCount;
  markers.records = in.take(markers.count * markers.record_bytes);
  if (!into) into = markers;
  return QtmError::kNone;
}

QtmError read_timecode(ByteReader in, std::optional<QtmTimecode>& into) noexcept {
  constexpr std::size_t kEntryBytes = 12;
  const auto count = in.read<std::uint32_t>();
  if (!in.ok() || count > in.remaining() / kEntryBytes) return QtmError::kBadCount;
  if (count == 0 || into) return QtmError::kNone;
  QtmTimecode timecode;
  timecode.type = in.read<std::uint32_t>();
  timecode.high = in.read<std::uint32_t>();
  timecode.low = in.read<std::uint32_t>();
  into = timecode;
  return QtmError::kNone;
}

QtmError read_component(std::uint32_t type, std::span<const std::byte> body, QtmData& data) noexcept {
  const auto component = static_cast<QtmComponent>(type);
  switch (component) {
    case QtmComponent::k3d:
    case QtmComponent::k3dResiduals:
      return body.empty() ? QtmError::kNone : read_markers(component, ByteReader(body), data.labelled);
    case QtmComponent::k3dNoLabels:
    case QtmComponent::k3dNoLabelsResiduals:
      return body.empty() ? QtmError::kNone : read_markers(component, ByteReader(body), data.unlabelled);
    case QtmComponent::kTimecode:
      return body.empty() ? QtmError::kNone : read_timecode(ByteReader(body), data.timecode);
    default:
      ++data.other_components;
      return QtmError::kNone;
  }
}

std::size_t begin_packet(QtmPacketType type, ByteAppender& out) {
  const std::size_t start = out.size();
  out.append(std::uint32_t{0});
  out.append(static_cast<std::uint32_t>(type));
  return start;
}

void end_packet(std::size_t start, ByteAppender& out) {
  out.patch(start, static_cast<std::uint32_t>(out.size() - start));
}

void append_markers(QtmComponent type, std::span<const std::optional<std::array<float, 3>>> positions_mm,
                    ByteAppender& out) {
  const std::size_t start = out.size();
  out.append(std::uint32_t{0});
  out.append(static_cast<std::uint32_t>(type));
  out.append(static_cast<std::uint32_t>(positions_mm.size()));
  out.append(std::uint16_t{0});
  out.append(std::uint16_t{0});
  for (const auto& position : positions_mm) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.append(position ? std::bit_cast<std::uint32_t>((*position)[axis]) : kNotSeenBits);
    }
    if (type == QtmComponent::k3dResiduals) out.append(position ? std::uint32_t{0} : kNotSeenBits);
  }
  end_packet(start, out);
}

void append_timecode(const std::optional<Timecode>& timecode, ByteAppender& out) {
  const std::size_t start = out.size();
  out.append(std::uint32_t{0});
  out.append(static_cast<std::uint32_t>(QtmComponent::kTimecode));
  out.append(std::uint32_t{timecode ? 1U : 0U});
  if (timecode) {
    out.append(kSmpte);
    out.append(std::uint32_t{0});
    out.append(std::uint32_t{timecode->hours} | std::uint32_t{timecode->minutes} << 5 |
               std::uint32_t{timecode->seconds} << 11 | std::uint32_t{timecode->frames} << 17);
  }
  end_packet(start, out);
}

}  // namespace

PacketStatus take_qtm_packet(std::span<const std::byte>& bytes, std::size_t max_bytes, QtmPacket& packet) noexcept {
  ByteReader in(bytes);
  const auto size = in.read<std::uint32_t>();
  const auto type = in.read<std::uint32_t>();
  if (!in.ok()) return PacketStatus::kIncomplete;
  if (size < kQtmHeaderBytes || size > max_bytes) return PacketStatus::kBad;
  if (size > bytes.size()) return PacketStatus::kIncomplete;
  packet = {.type = static_cast<QtmPacketType>(type), .body = bytes.subspan(kQtmHeaderBytes, size - kQtmHeaderBytes)};
  bytes = bytes.subspan(size);
  return PacketStatus::kWhole;
}

QtmError read_qtm_datagram(std::span<const std::byte> datagram, QtmPacket& packet) noexcept {
  if (datagram.size() < kQtmHeaderBytes) return QtmError::kTooShort;
  const bool whole = take_qtm_packet(datagram, datagram.size(), packet) == PacketStatus::kWhole;
  return whole && datagram.empty() ? QtmError::kNone : QtmError::kBadSize;
}

std::string_view qtm_text(std::span<const std::byte> body) noexcept {
  const std::string_view all(reinterpret_cast<const char*>(body.data()), body.size());
  return all.substr(0, all.find('\0'));
}

std::optional<QtmEvent> qtm_event(std::span<const std::byte> body) noexcept {
  if (body.empty()) return {};
  const auto number = static_cast<std::uint8_t>(body[0]);
  if (number < static_cast<std::uint8_t>(QtmEvent::kConnected) ||
      number > static_cast<std::uint8_t>(QtmEvent::kTrigger)) {
    return {};
  }
  return static_cast<QtmEvent>(number);
}

std::optional<std::array<float, 3>> QtmMarkers::position(std::size_t i) const noexcept {
  std::array<float, 3> xyz{};
  std::memcpy(xyz.data(), records.data() + i * record_bytes, sizeof xyz);
  for (const float value : xyz)
    if (!std::isfinite(value)) return {};
  return xyz;
}

std::optional<Timecode> QtmTimecode::clock(std::uint8_t smpte_rate) const noexcept {
  if (type != kSmpte && type != kIrig) return {};
  Timecode time;
  time.hours = static_cast<std::uint8_t>(low & 0x1F);
  time.minutes = static_cast<std::uint8_t>(low >> 5 & 0x3F);
  time.seconds = static_cast<std::uint8_t>(low >> 11 & 0x3F);
  time.frames = static_cast<std::uint8_t>(low >> 17 & (type == kSmpte ? 0x1F : 0x0F));
  time.frame_rate = type == kSmpte ? smpte_rate : std::uint8_t{10};
  return time.possible() ? std::optional(time) : std::nullopt;
}

QtmError decode_qtm_data(std::span<const std::byte> body, QtmData& data) noexcept {
  data = {};
  ByteReader in(body);
  data.timestamp_us = in.read<std::uint64_t>();
  data.frame = in.read<std::uint32_t>();
  const auto components = in.read<std::uint32_t>();
  if (!in.ok()) return QtmError::kTooShort;
  for (std::uint32_t i = 0; i < components; ++i) {
    const auto size = in.read<std::uint32_t>();
    const auto type = in.read<std::uint32_t>();
    // Also ends the loop when a count promises more components than there are bytes.
    if (!in.ok() || size < kQtmHeaderBytes || size - kQtmHeaderBytes > in.remaining()) return QtmError::kBadComponent;
    const QtmError error = read_component(type, in.take(size - kQtmHeaderBytes), data);
    if (error != QtmError::kNone) return error;
  }
  return QtmError::kNone;
}

std::string_view name_of(QtmError error) noexcept {
  switch (error) {
    case QtmError::kNone:
      return "none";
    case QtmError::kTooShort:
      return "too_short";
    case QtmError::kBadSize:
      return "bad_size";
    case QtmError::kBadComponent:
      return "bad_component";
    case QtmError::kBadCount:
      return "bad_count";
  }
  return "unknown";
}

void append_qtm_text(QtmPacketType type, std::string_view text, ByteAppender& out) {
  const std::size_t start = begin_packet(type, out);
  out.append_text(text);
  out.append(std::uint8_t{0});
  end_packet(start, out);
}

void append_qtm_event(QtmEvent event, ByteAppender& out) {
  const std::size_t start = begin_packet(QtmPacketType::kEvent, out);
  out.append(static_cast<std::uint8_t>(event));
  end_packet(start, out);
}

void append_qtm_no_more_data(ByteAppender& out) { end_packet(begin_packet(QtmPacketType::kNoMoreData, out), out); }

void append_qtm_data(std::uint64_t timestamp_us, std::uint32_t frame, const QtmComponents& components,
                     std::span<const std::optional<std::array<float, 3>>> positions_mm,
                     const std::optional<Timecode>& timecode, ByteAppender& out) {
  const std::size_t start = begin_packet(QtmPacketType::kData, out);
  out.append(timestamp_us);
  out.append(frame);
  out.append(std::uint32_t{components.markers} + components.residuals + components.unlabelled +
             components.unlabelled_residuals + components.timecode);
  if (components.markers) append_markers(QtmComponent::k3d, positions_mm, out);
  if (components.unlabelled) append_markers(QtmComponent::k3dNoLabels, {}, out);
  if (components.residuals) append_markers(QtmComponent::k3dResiduals, positions_mm, out);
  if (components.unlabelled_residuals) append_markers(QtmComponent::k3dNoLabelsResiduals, {}, out);
  if (components.timecode) append_timecode(timecode, out);
  end_packet(start, out);
}

}  // namespace risorius
