#include "capture/wire/marker_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "capture/check.h"
#include "capture/plausible_position.h"
#include "capture/utf8.h"
#include "capture/wire/byte_io.h"
#include "capture/wire/crc32c.h"

namespace risorius {
namespace {

constexpr std::string_view kMagic = "RISO";
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kChecksumBytes = 4;
constexpr std::size_t kBytesPerMarker = 3 * sizeof(float);

enum class MessageType : std::uint16_t { kMarkerSet = 1, kMarkerFrame = 2, kEndOfStream = 3 };

struct MessageHeader {
  std::uint16_t type = 0;
  std::uint32_t session = 0;
  std::uint32_t set_id = 0;
};

constexpr std::size_t bitmap_bytes(std::size_t count) noexcept { return (count + 7) / 8; }

static_assert(kHeaderBytes + 28 + bitmap_bytes(kMaxMarkersPerDatagram) + kMaxMarkersPerDatagram * kBytesPerMarker +
                      kChecksumBytes <=
                  kMaxDatagramBytes &&
              kHeaderBytes + 28 + bitmap_bytes(kMaxMarkersPerDatagram + 1) +
                      (kMaxMarkersPerDatagram + 1) * kBytesPerMarker + kChecksumBytes >
                  kMaxDatagramBytes);

std::string_view as_text(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> as_span(std::string_view text) noexcept {
  return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

DecodeError open(std::span<const std::byte> datagram, MessageHeader& header, ByteReader& body) noexcept {
  if (datagram.size() < kHeaderBytes + kChecksumBytes) return DecodeError::kTooShort;
  if (datagram.size() > kMaxDatagramBytes) return DecodeError::kTooLong;
  const auto checked = datagram.first(datagram.size() - kChecksumBytes);
  ByteReader reader(checked);
  if (as_text(reader.take(kMagic.size())) != kMagic) return DecodeError::kBadMagic;
  if (reader.read<std::uint16_t>() != kProtocolVersion) return DecodeError::kBadVersion;
  if (ByteReader(datagram.last(kChecksumBytes)).read<std::uint32_t>() != crc32c(checked))
    return DecodeError::kBadChecksum;
  header.type = reader.read<std::uint16_t>();
  header.session = reader.read<std::uint32_t>();
  header.set_id = reader.read<std::uint32_t>();
  body = reader;
  return DecodeError::kNone;
}

/// Reads the three counts that say which part of the whole this is.
template <class Part>
bool read_range(ByteReader& body, Part& part) noexcept {
  part.count = body.read<std::uint16_t>();
  part.first = body.read<std::uint16_t>();
  part.part_count = body.read<std::uint16_t>();
  return part.count >= 1 && part.count <= kMaxMarkers && part.part_count >= 1 &&
         part.first + part.part_count <= part.count;
}

bool is_name(std::string_view name) noexcept {
  return !name.empty() && name.size() <= kMaxNameBytes && is_clean_utf8(name);
}

DecodeError decode_set(const MessageHeader& header, ByteReader body, NativeMessage& message) noexcept {
  MarkerSetPart part;
  part.session = header.session;
  part.set_id = header.set_id;
  part.rate_hz = body.read<double>();
  part.mm_per_unit = body.read<double>();
  const auto letters = body.take(4);
  part.revision = body.read<std::uint16_t>();
  const bool range_ok = read_range(body, part);
  if (!body.ok()) return DecodeError::kBadLength;
  if (!range_ok) return DecodeError::kBadCount;
  const auto axes = Axes::parse(as_text(letters.first(3)));
  if (!axes || letters[3] != std::byte{0}) return DecodeError::kBadValue;
  part.axes = *axes;
  if (!std::isfinite(part.rate_hz) || part.rate_hz < 0) return DecodeError::kBadValue;
  if (!std::isfinite(part.mm_per_unit) || part.mm_per_unit <= 0) return DecodeError::kBadValue;
  ByteReader names = body;
  part.names = body.take(body.remaining());
  for (std::size_t i = 0; i < part.part_count; ++i) {
    const std::string_view name = as_text(names.take(names.read<std::uint8_t>()));
    if (!names.ok()) return DecodeError::kBadLength;
    if (!is_name(name)) return DecodeError::kBadValue;
  }
  if (names.remaining() != 0) return DecodeError::kBadLength;
  message = part;
  return DecodeError::kNone;
}

DecodeError decode_frame(const MessageHeader& header, ByteReader body, NativeMessage& message) noexcept {
  MarkerFramePart part;
  part.session = header.session;
  part.set_id = header.set_id;
  part.sequence = body.read<std::uint64_t>();
  part.capture_time_ns = body.read<std::int64_t>();
  Timecode& timecode = part.timecode;
  for (std::uint8_t* field :
       {&timecode.hours, &timecode.minutes, &timecode.seconds, &timecode.frames, &timecode.frame_rate}) {
    *field = body.read<std::uint8_t>();
  }
  const auto flags = body.read<std::uint8_t>();
  timecode.drop_frame = (flags & 1) != 0;
  const bool range_ok = read_range(body, part);
  if (!body.ok()) return DecodeError::kBadLength;
  if (!range_ok) return DecodeError::kBadCount;
  if (flags > 1) return DecodeError::kBadValue;
  part.valid_bits = body.take(bitmap_bytes(part.part_count));
  part.positions = body.take(part.part_count * kBytesPerMarker);
  if (!body.ok() || body.remaining() != 0) return DecodeError::kBadLength;
  message = part;
  return DecodeError::kNone;
}

DecodeError decode_end(const MessageHeader& header, ByteReader body, NativeMessage& message) noexcept {
  EndOfStream end;
  end.session = header.session;
  end.frames_sent = body.read<std::uint64_t>();
  end.last_sequence = body.read<std::uint64_t>();
  if (!body.ok() || body.remaining() != 0) return DecodeError::kBadLength;
  message = end;
  return DecodeError::kNone;
}

ByteWriter start(DatagramBuffer& out, MessageType type, std::uint32_t session, std::uint32_t set_id) noexcept {
  ByteWriter writer(std::span<std::byte>(out).first(kMaxDatagramBytes - kChecksumBytes));
  writer.write_bytes(as_span(kMagic));
  writer.write(kProtocolVersion);
  writer.write(static_cast<std::uint16_t>(type));
  writer.write(session);
  writer.write(set_id);
  return writer;
}

std::size_t finish(const ByteWriter& writer, DatagramBuffer& out) noexcept {
  RISORIUS_CHECK(writer.ok());
  ByteWriter checksum(std::span<std::byte>(out).subspan(writer.size(), kChecksumBytes));
  checksum.write(crc32c(writer.written()));
  return writer.size() + kChecksumBytes;
}

void write_range(ByteWriter& writer, std::size_t count, std::size_t first, std::size_t part_count) noexcept {
  for (const std::size_t value : {count, first, part_count}) writer.write(static_cast<std::uint16_t>(value));
}

}  // namespace

std::span<const std::string_view> decode_error_names() noexcept {
  static constexpr std::array<std::string_view, kDecodeErrorCount> kNames{
      "none",           "too_short",         "too_long",  "bad_magic",    "bad_version", "bad_checksum",
      "bad_type",       "bad_length",        "bad_count", "bad_value",    "unknown_set", "other_session",
      "count_mismatch", "inconsistent_part", "bad_set",   "too_many_sets"};
  return kNames;
}

std::string_view name_of(DecodeError error) noexcept { return decode_error_names()[static_cast<std::size_t>(error)]; }

std::string_view take_name(std::span<const std::byte>& names) noexcept {
  ByteReader reader(names);
  const auto name = reader.take(reader.read<std::uint8_t>());
  names = names.last(reader.remaining());
  return as_text(name);
}

std::size_t place_markers(const MarkerFramePart& part, double mm_per_unit, const Axes& axes,
                          MarkerFrame& frame) noexcept {
  ByteReader positions(part.positions);
  std::size_t not_finite = 0;
  // A product with 1 is exact, so that millimetres pass bit for bit.
  const auto to_mm = [mm_per_unit](float value) {
    return static_cast<float>(mm_per_unit * static_cast<double>(value));
  };
  for (std::size_t i = 0; i < part.part_count; ++i) {
    const float x = to_mm(positions.read<float>());
    const float y = to_mm(positions.read<float>());
    const float z = to_mm(positions.read<float>());
    const bool valid = ((part.valid_bits[i / 8] >> (i % 8)) & std::byte{1}) != std::byte{0};
    const bool finite = is_plausible_position(x, y, z);
    const std::size_t marker = part.first + i;
    frame.state[marker] = valid && finite ? MarkerState::kMeasured : MarkerState::kMissing;
    frame.reason[marker] = valid && !finite ? RejectReason::kNotFinite : RejectReason::kNone;
    frame.position_mm[marker] = valid && finite ? axes.to_world(x, y, z) : Position{};
    not_finite += valid && !finite ? 1 : 0;
  }
  return not_finite;
}

DecodeError decode(std::span<const std::byte> datagram, NativeMessage& message) noexcept {
  MessageHeader header;
  ByteReader body({});
  if (const DecodeError error = open(datagram, header, body); error != DecodeError::kNone) return error;
  switch (static_cast<MessageType>(header.type)) {
    case MessageType::kMarkerSet:
      return decode_set(header, body, message);
    case MessageType::kMarkerFrame:
      return decode_frame(header, body, message);
    case MessageType::kEndOfStream:
      return decode_end(header, body, message);
  }
  return DecodeError::kBadType;
}

EncodedPart encode(const MarkerSet& set, std::uint32_t session, std::uint16_t revision, std::size_t first,
                   DatagramBuffer& out) noexcept {
  RISORIUS_CHECK(first < set.names.size() && set.names.size() <= kMaxMarkers);
  // Of the largest head that a set can have: header, rate, unit, axes, revision, range.
  std::size_t room = kMaxDatagramBytes - kChecksumBytes - (kHeaderBytes + 28);
  std::size_t next = first;
  while (next < set.names.size() && 1 + set.names[next].size() <= room) room -= 1 + set.names[next++].size();
  RISORIUS_CHECK(next > first);

  ByteWriter writer = start(out, MessageType::kMarkerSet, session, set.id);
  writer.write(set.rate_hz);
  writer.write(set.mm_per_unit);
  writer.write_bytes(as_span(set.axes.letters()));
  writer.write(std::uint8_t{0});
  writer.write(revision);
  write_range(writer, set.names.size(), first, next - first);
  for (std::size_t i = first; i < next; ++i) {
    writer.write(static_cast<std::uint8_t>(set.names[i].size()));
    writer.write_bytes(as_span(set.names[i]));
  }
  return {finish(writer, out), next};
}

EncodedPart encode(const MarkerFrame& frame, std::uint32_t session, std::size_t first, DatagramBuffer& out) noexcept {
  RISORIUS_CHECK(first < frame.count && frame.count <= kMaxMarkers);
  const std::size_t part_count = std::min<std::size_t>(frame.count - first, kMaxMarkersPerDatagram);
  ByteWriter writer = start(out, MessageType::kMarkerFrame, session, frame.header.set_id);
  writer.write(frame.header.sequence);
  writer.write(frame.header.capture_time_ns);
  const Timecode& timecode = frame.header.timecode;
  for (const std::uint8_t field : {timecode.hours, timecode.minutes, timecode.seconds, timecode.frames,
                                   timecode.frame_rate, static_cast<std::uint8_t>(timecode.drop_frame ? 1 : 0)}) {
    writer.write(field);
  }
  write_range(writer, frame.count, first, part_count);
  const auto valid = [&](std::size_t i) { return frame.state[first + i] == MarkerState::kMeasured; };
  for (std::size_t byte = 0; byte < bitmap_bytes(part_count); ++byte) {
    unsigned bits = 0;
    for (std::size_t i = 8 * byte; i < std::min(part_count, 8 * byte + 8); ++i) bits |= valid(i) ? 1u << (i % 8) : 0u;
    writer.write(static_cast<std::uint8_t>(bits));
  }
  for (std::size_t i = 0; i < part_count; ++i) {
    const Position p = valid(i) ? frame.position_mm[first + i] : Position{};
    for (const float value : {p.x, p.y, p.z}) writer.write(value);
  }
  return {finish(writer, out), first + part_count};
}

std::size_t encode(const EndOfStream& end, DatagramBuffer& out) noexcept {
  ByteWriter writer = start(out, MessageType::kEndOfStream, end.session, 0);
  writer.write(end.frames_sent);
  writer.write(end.last_sequence);
  return finish(writer, out);
}

}  // namespace risorius
