#include "replay/session/tick_codec.h"

#include <algorithm>

#include "capture/wire/byte_io.h"

namespace risorius {
namespace {

constexpr std::uint8_t kTickVersion = 1;
constexpr std::size_t kLongestText = 4096;

/// Not inlined: g++ 12 takes what follows a clear() for a write beyond the end.
[[gnu::noinline]] void clear(ByteAppender& out) { out.clear(); }

void begin(TickKind kind, ByteAppender& out) {
  clear(out);
  const std::array<std::uint8_t, 2> head{kTickVersion, static_cast<std::uint8_t>(kind)};
  out.append_bytes(std::as_bytes(std::span(head)));
}

void append_text(std::string_view text, ByteAppender& out) {
  out.append(static_cast<std::uint16_t>(text.size()));
  out.append_text(text);
}

bool read_text(ByteReader& in, std::string& text) {
  const auto size = in.read<std::uint16_t>();
  const auto bytes = in.take(size);
  if (!in.ok() || size > kLongestText) return false;
  text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return true;
}

void append(const FrameHeader& header, ByteAppender& out) {
  out.append(header.stream_id);
  out.append(header.set_id);
  out.append(header.sequence);
  out.append(header.capture_time_ns);
  out.append(header.receive_time_ns);
  const Timecode& t = header.timecode;
  const std::array<std::uint8_t, 6> timecode{t.hours,  t.minutes,    t.seconds,
                                             t.frames, t.frame_rate, static_cast<std::uint8_t>(t.drop_frame ? 1 : 0)};
  out.append_bytes(std::as_bytes(std::span(timecode)));
}

void read(ByteReader& in, FrameHeader& header) {
  header.stream_id = in.read<std::uint32_t>();
  header.set_id = in.read<std::uint32_t>();
  header.sequence = in.read<std::uint64_t>();
  header.capture_time_ns = in.read<std::int64_t>();
  header.receive_time_ns = in.read<std::int64_t>();
  Timecode& t = header.timecode;
  for (std::uint8_t* part : {&t.hours, &t.minutes, &t.seconds, &t.frames, &t.frame_rate})
    *part = in.read<std::uint8_t>();
  t.drop_frame = in.read<std::uint8_t>() != 0;
}

/// The first `count` values as they lie in memory.
template <class T, std::size_t N>
void append_values(const std::array<T, N>& values, std::uint32_t count, ByteAppender& out) {
  out.append_bytes(std::as_bytes(std::span(values).first(count)));
}

template <class T, std::size_t N>
void read_values(ByteReader& in, std::uint32_t count, std::array<T, N>& values) {
  const auto bytes = in.take(count * sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
}

/// Whether the next `count` bytes can be enumerators; takes none of them.
template <class Enum>
bool are_enumerators(ByteReader in, std::uint32_t count, Enum last) {
  return std::ranges::all_of(in.take(count), [last](std::byte byte) {
    return std::to_integer<std::uint8_t>(byte) <= static_cast<std::uint8_t>(last);
  });
}

bool read(ByteReader& in, MarkerFrame& frame) {
  frame = MarkerFrame{};
  read(in, frame.header);
  frame.count = in.read<std::uint32_t>();
  const bool has_extras = in.read<std::uint16_t>() != 0;
  if (!in.ok() || frame.count > kMaxMarkers) return false;
  if (!are_enumerators(in, frame.count, MarkerState::kRejected)) return false;
  read_values(in, frame.count, frame.state);
  read_values(in, frame.count, frame.position_mm);
  if (!has_extras) return in.ok();
  if (!are_enumerators(in, frame.count, RejectReason::kNotFinite)) return false;
  read_values(in, frame.count, frame.reason);
  read_values(in, frame.count, frame.standard_deviation_mm);
  return in.ok();
}

bool read(ByteReader& in, ShapeFrame& shapes) {
  shapes = ShapeFrame{};
  read(in, shapes.header);
  shapes.has_face = in.read<std::uint16_t>() != 0;
  read_values(in, kFaceShapes, shapes.value);
  return in.ok();
}

bool read(ByteReader& in, MarkerSet& set, bool& has_names) {
  set = MarkerSet{};
  set.id = in.read<std::uint32_t>();
  set.rate_hz = in.read<double>();
  set.mm_per_unit = in.read<double>();
  std::string letters;
  if (!read_text(in, letters)) return false;
  const auto axes = Axes::parse(letters);
  const auto count = in.read<std::uint32_t>();
  if (!axes || !in.ok() || count > kMaxMarkers) return false;
  set.axes = *axes;
  set.names.resize(count);
  has_names = count > 0;
  return std::ranges::all_of(set.names, [&](std::string& name) { return read_text(in, name); });
}

}  // namespace

void encode_tick(const MarkerFrame& frame, ByteAppender& out) {
  begin(TickKind::kFrame, out);
  append(frame.header, out);
  out.append(frame.count);
  bool has_extras = false;
  for (std::uint32_t m = 0; m < frame.count; ++m) {
    has_extras = has_extras || frame.reason[m] != RejectReason::kNone || frame.standard_deviation_mm[m] != 0;
  }
  out.append(static_cast<std::uint16_t>(has_extras ? 1 : 0));
  append_values(frame.state, frame.count, out);
  append_values(frame.position_mm, frame.count, out);
  if (!has_extras) return;
  append_values(frame.reason, frame.count, out);
  append_values(frame.standard_deviation_mm, frame.count, out);
}

void encode_tick(const ShapeFrame& shapes, ByteAppender& out) {
  begin(TickKind::kShapes, out);
  append(shapes.header, out);
  out.append(static_cast<std::uint16_t>(shapes.has_face ? 1 : 0));
  append_values(shapes.value, kFaceShapes, out);
}

void encode_tick(const MarkerSet& set, ByteAppender& out) {
  begin(TickKind::kMarkerSet, out);
  out.append(set.id);
  out.append(set.rate_hz);
  out.append(set.mm_per_unit);
  append_text(set.axes.letters(), out);
  out.append(static_cast<std::uint32_t>(set.names.size()));
  for (const std::string& name : set.names) append_text(name, out);
}

void encode_end_of_stream_tick(ByteAppender& out) { begin(TickKind::kEndOfStream, out); }

void encode_neutral_tick(std::int64_t duration_ns, ByteAppender& out) {
  begin(TickKind::kNeutralCapture, out);
  out.append(duration_ns);
}

void encode_recording_tick(bool started, std::string_view name, ByteAppender& out) {
  begin(started ? TickKind::kRecordingStarted : TickKind::kRecordingStopped, out);
  append_text(name, out);
}

bool is_marker_set_tick(std::span<const std::byte> bytes) noexcept {
  return bytes.size() >= 2 &&
         std::to_integer<std::uint8_t>(bytes[1]) == static_cast<std::uint8_t>(TickKind::kMarkerSet);
}

bool decode_tick(std::span<const std::byte> bytes, SessionTick& tick) {
  ByteReader in(bytes);
  const auto version = in.read<std::uint8_t>(), kind = in.read<std::uint8_t>();
  if (!in.ok() || version != kTickVersion || kind > static_cast<std::uint8_t>(TickKind::kRecordingStopped))
    return false;
  tick.kind = static_cast<TickKind>(kind);
  bool fits = true, has_names = false;
  switch (tick.kind) {
    case TickKind::kFrame:
      fits = read(in, tick.frame);
      break;
    case TickKind::kShapes:
      fits = read(in, tick.shapes);
      break;
    case TickKind::kMarkerSet:
      // The set of a stream of face shapes has no names; it states the rate.
      fits = read(in, tick.set, has_names) && (!has_names || problems_of(tick.set).empty());
      break;
    case TickKind::kEndOfStream:
      break;
    case TickKind::kNeutralCapture:
      tick.duration_ns = in.read<std::int64_t>();
      break;
    case TickKind::kRecordingStarted:
    case TickKind::kRecordingStopped:
      fits = read_text(in, tick.recording_name);
      break;
  }
  return fits && in.ok() && in.remaining() == 0;
}

}  // namespace risorius
