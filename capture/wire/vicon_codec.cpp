#include "capture/wire/vicon_codec.h"

#include <cstring>

#include "capture/wire/byte_io.h"

namespace risorius {
namespace {

constexpr std::size_t kLabelledBytes = 116, kUnlabelledBytes = 108;

/// A u32 and so many bytes.
std::optional<std::string_view> read_text(ByteReader& in) noexcept {
  const auto bytes = in.take(in.read<std::uint32_t>());
  if (!in.ok()) return {};
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// A count of elements of at least `smallest` bytes each; empty if they cannot all be there.
std::optional<std::size_t> read_count(ByteReader& in, std::size_t smallest) noexcept {
  const std::size_t count = in.read<std::uint32_t>();
  if (!in.ok() || count > in.remaining() / smallest) return {};
  return count;
}

bool skip_segments(ByteReader& in) noexcept {
  constexpr std::size_t kParentIdBounds = 4 + 4 + 6 * 4;
  const auto count = read_count(in, kParentIdBounds + 4);
  if (!count) return false;
  for (std::size_t i = 0; i < *count; ++i) {
    in.take(kParentIdBounds);
    if (!read_text(in)) return false;
  }
  return true;
}

template <class T>
std::optional<T> read_one(std::span<const std::byte> body) noexcept {
  ByteReader in(body);
  const T value = in.read<T>();
  return in.ok() ? std::optional(value) : std::nullopt;
}

struct Standard {
  std::uint8_t rate;
  bool drop_frame;
};
// By the protocol's number. Timecode counts whole frames: 29.97 Hz shows 30 in a second, 23.976 Hz shows 24.
constexpr std::array<Standard, 6> kStandards{
    {{25, false}, {30, false}, {30, true}, {24, false}, {24, false}, {30, false}}};

}  // namespace

std::string_view name_of(ViconError error) noexcept {
  switch (error) {
    case ViconError::kNone:
      return "none";
    case ViconError::kTooShort:
      return "too_short";
    case ViconError::kBadTag:
      return "bad_tag";
    case ViconError::kTooLong:
      return "too_long";
    case ViconError::kBadObject:
      return "bad_object";
    case ViconError::kBadLength:
      return "bad_length";
  }
  return "unknown";
}

PacketStatus take_vicon_packet(std::span<const std::byte>& bytes, std::size_t max_bytes,
                               std::span<const std::byte>& objects, ViconError& error) noexcept {
  ByteReader in(bytes);
  const auto tag = in.read<std::uint32_t>();
  if (!in.ok()) return PacketStatus::kIncomplete;
  if (tag != kViconTag) {
    error = ViconError::kBadTag;
    return PacketStatus::kBad;
  }
  const auto length = in.read<std::uint32_t>();
  if (!in.ok()) return PacketStatus::kIncomplete;
  if (length > max_bytes) {
    error = ViconError::kTooLong;
    return PacketStatus::kBad;
  }
  if (length > in.remaining()) return PacketStatus::kIncomplete;
  objects = in.take(length);
  bytes = bytes.subspan(kViconHeaderBytes + length);
  return PacketStatus::kWhole;
}

bool take_vicon_object(std::span<const std::byte>& objects, ViconObject& object) noexcept {
  ByteReader in(objects);
  object.id = in.read<std::uint32_t>();
  const auto length = in.read<std::uint32_t>();
  object.body = in.take(length);
  if (!in.ok()) return false;
  objects = objects.subspan(kViconHeaderBytes + length);
  return true;
}

bool ViconIds::contains(std::uint32_t id) const noexcept {
  for (std::size_t i = 0; i < size(); ++i) {
    std::uint32_t one = 0;
    std::memcpy(&one, ids_.data() + 4 * i, sizeof one);
    if (one == id) return true;
  }
  return false;
}

std::optional<Timecode> ViconTimecode::clock() const noexcept {
  if (standard >= kStandards.size()) return {};
  const Standard& is = kStandards[standard];
  const Timecode time{hours, minutes, seconds, frames, is.rate, is.drop_frame};
  return time.possible() ? std::optional(time) : std::nullopt;
}

ViconRecon ViconRecons::operator[](std::size_t i) const noexcept {
  const std::size_t bytes = labelled ? kLabelledBytes : kUnlabelledBytes;
  ByteReader in(records.subspan(i * bytes, bytes));
  ViconRecon recon;
  if (labelled) {
    recon.subject = in.read<std::uint32_t>();
    recon.marker = in.read<std::uint32_t>();
  }
  in.read<double>();  // radius
  for (double& axis : recon.position_mm) axis = in.read<double>();
  return recon;
}

std::optional<ViconIds> decode_vicon_ids(std::span<const std::byte> body) noexcept {
  ByteReader in(body);
  const auto count = read_count(in, 4);
  if (!count) return {};
  return ViconIds(in.take(*count * 4));
}

std::optional<ViconContents> decode_vicon_contents(std::span<const std::byte> body) noexcept {
  ByteReader in(body);
  const auto kinds = read_count(in, 8);
  if (!kinds) return {};
  in.take(*kinds * 8);
  const auto unchanged = read_count(in, 4);
  if (!unchanged) return {};
  return ViconContents{.unchanged = ViconIds(in.take(*unchanged * 4))};
}

std::optional<ViconSubject> decode_vicon_subject(std::span<const std::byte> body) {
  ByteReader in(body);
  ViconSubject subject;
  subject.id = in.read<std::uint32_t>();
  const auto name = read_text(in);
  if (!name || !skip_segments(in)) return {};
  subject.name = *name;
  const auto markers = read_count(in, 8);
  if (!markers) return {};
  for (std::size_t i = 0; i < *markers; ++i) {
    const auto id = in.read<std::uint32_t>();
    const auto marker = read_text(in);
    if (!marker) return {};
    subject.markers.push_back({.id = id, .name = std::string(*marker)});
  }
  const auto attachments = read_count(in, 8);
  if (!attachments) return {};
  return subject;
}

std::optional<ViconTimecode> decode_vicon_timecode(std::span<const std::byte> body) noexcept {
  ByteReader in(body);
  ViconTimecode timecode;
  timecode.hours = in.read<std::uint8_t>();
  timecode.minutes = in.read<std::uint8_t>();
  timecode.seconds = in.read<std::uint8_t>();
  timecode.frames = in.read<std::uint8_t>();
  in.read<std::uint16_t>();  // subframe
  in.read<std::uint16_t>();  // subframes per frame
  timecode.standard = in.read<std::uint32_t>();
  in.read<std::uint32_t>();  // user bits
  in.read<std::uint8_t>();   // field flag
  return in.ok() ? std::optional(timecode) : std::nullopt;
}

std::optional<ViconRecons> decode_vicon_recons(std::span<const std::byte> body, bool labelled) noexcept {
  const std::size_t bytes = labelled ? kLabelledBytes : kUnlabelledBytes;
  ByteReader in(body);
  const auto count = read_count(in, bytes);
  if (!count) return {};
  return ViconRecons{.count = *count, .labelled = labelled, .records = in.take(*count * bytes)};
}

std::optional<double> decode_vicon_latency_s(std::span<const std::byte> body) noexcept {
  ByteReader in(body);
  const auto count = read_count(in, 4 + 8);
  if (!count) return {};
  double sum = 0;
  for (std::size_t i = 0; i < *count; ++i) {
    if (!read_text(in)) return {};
    sum += in.read<double>();
  }
  return in.ok() ? std::optional(sum) : std::nullopt;
}

std::optional<std::int64_t> decode_vicon_i64(std::span<const std::byte> body) noexcept {
  return read_one<std::int64_t>(body);
}
std::optional<std::uint32_t> decode_vicon_u32(std::span<const std::byte> body) noexcept {
  return read_one<std::uint32_t>(body);
}
std::optional<std::uint8_t> decode_vicon_u8(std::span<const std::byte> body) noexcept {
  return read_one<std::uint8_t>(body);
}

}  // namespace risorius
