#include "replay/live/messages.h"

#include <cmath>
#include <msgpuck.h>

#include "capture/check.h"
#include "capture/frame_words.h"

namespace risorius {
namespace {

/// Writes MessagePack into a buffer that is large enough for anything a frame can hold.
class MapWriter {
 public:
  MapWriter(MessageBuffer& buffer, std::size_t bytes, std::uint32_t entries) : buffer_(buffer) {
    buffer_.resize(bytes);
    at_ = mp_encode_map(buffer_.data(), entries);
  }
  void key(std::string_view name) { at_ = mp_encode_str(at_, name.data(), static_cast<std::uint32_t>(name.size())); }
  void text(std::string_view value) { key(value); }
  void number(double value) { at_ = mp_encode_double(at_, value); }
  void number(float value) { at_ = mp_encode_float(at_, value); }
  void count(std::uint64_t value) { at_ = mp_encode_uint(at_, value); }
  void integer(std::int64_t value) {
    at_ = value < 0 ? mp_encode_int(at_, value) : mp_encode_uint(at_, static_cast<std::uint64_t>(value));
  }
  void array(std::size_t entries) { at_ = mp_encode_array(at_, static_cast<std::uint32_t>(entries)); }
  void map(std::size_t entries) { at_ = mp_encode_map(at_, static_cast<std::uint32_t>(entries)); }
  void nothing() { at_ = mp_encode_nil(at_); }
  void finish() {
    const auto used = static_cast<std::size_t>(at_ - buffer_.data());
    RISORIUS_CHECK(used <= buffer_.size());
    buffer_.resize(used);
  }

 private:
  MessageBuffer& buffer_;
  char* at_;
};

constexpr std::uint32_t kHeaderEntries = 8;

void write_header(MapWriter& out, const FrameHeader& header, const MessageContext& context) {
  out.key("version");
  out.count(1);
  out.key("stream");
  out.text(context.stream);
  out.key("message");
  out.count(context.message);
  out.key("sequence");
  out.count(header.sequence);
  out.key("capture_time_ns");
  out.integer(header.capture_time_ns);
  out.key("timecode");
  if (header.timecode.frame_rate == 0) {
    out.nothing();
  } else {
    out.text(text_of(header.timecode));
  }
  out.key("receive_time_ns");
  out.integer(header.receive_time_ns);
  out.key("publish_time_ns");
  out.integer(context.publish_time_ns);
}

/// nil if they are not known.
template <std::size_t N>
void write_numbers(MapWriter& out, bool known, const std::array<double, N>& numbers) {
  if (!known) return out.nothing();
  out.array(N);
  for (const double number : numbers) out.number(number);
}

/// An upper bound of what a message needs: the fixed part, the names, and `bytes_per_entry` for each entry.
std::size_t bound(const MessageContext& context, std::size_t bytes_per_entry) {
  std::size_t bytes = 1024 + context.stream.size();
  for (const auto& name : context.names) bytes += name.size() + 5 + bytes_per_entry;
  return bytes;
}

/// Three entries.
void write_aus(MapWriter& out, const AuFrame& frame, const MessageContext& context) {
  std::array<char, kMaxAus> states;
  out.key("au");
  out.map(frame.count);
  for (std::uint32_t i = 0; i < frame.count; ++i) {
    states[i] = letter_of(frame.state[i]);
    out.key(context.names[i]);
    if (frame.state[i] == AuState::kNotObserved) {
      out.nothing();
    } else {
      out.number(frame.intensity[i]);
    }
  }
  out.key("standard_deviation");
  out.array(frame.count);
  for (std::uint32_t i = 0; i < frame.count; ++i) {
    const double deviation = frame.standard_deviation[i];
    std::isnan(deviation) ? out.nothing() : out.number(deviation);
  }
  out.key("states");
  out.text({states.data(), frame.count});
}

}  // namespace

void encode_markers(const MarkerFrame& frame, const MessageContext& context, MessageBuffer& out_buffer) {
  RISORIUS_CHECK(context.names.size() == frame.count);
  MapWriter out(out_buffer, bound(context, 16), kHeaderEntries + 3);
  write_header(out, frame.header, context);
  std::array<char, kMaxMarkers> states;
  out.key("names");
  out.array(frame.count);
  for (const auto& name : context.names) out.text(name);
  out.key("positions_mm");
  out.array(3 * frame.count);
  for (std::uint32_t m = 0; m < frame.count; ++m) {
    const bool known = frame.state[m] == MarkerState::kMeasured || frame.state[m] == MarkerState::kFilled;
    states[m] = letter_of(frame.state[m]);
    for (const float coordinate : {frame.position_mm[m].x, frame.position_mm[m].y, frame.position_mm[m].z}) {
      if (known) {
        out.number(coordinate);
      } else {
        out.nothing();
      }
    }
  }
  out.key("states");
  out.text({states.data(), frame.count});
  out.finish();
}

void encode_aus(const AuFrame& frame, const MessageContext& context, MessageBuffer& out_buffer) {
  RISORIUS_CHECK(context.names.size() == frame.count);
  MapWriter out(out_buffer, bound(context, 32), kHeaderEntries + 9);
  write_header(out, frame.header, context);
  out.key("kind");
  out.text(word_of(frame.kind));
  out.key("status");
  out.text(word_of(frame.status));
  // Mapped from face shapes: there is no residual and no pose that could be told.
  const bool has_solve = frame.kind != AuFrameKind::kMapped;
  out.key("residual_rms_mm");
  has_solve ? out.number(frame.residual_rms_mm) : out.nothing();
  out.key("kkt_residual");
  has_solve ? out.number(frame.kkt_residual) : out.nothing();
  out.key("rotation_xyzw");
  write_numbers(out, has_solve, frame.world_from_head.rotation_xyzw);
  out.key("translation_mm");
  write_numbers(out, has_solve, frame.world_from_head.translation_mm);
  write_aus(out, frame, context);
  out.finish();
}

void encode_shown(const ShownFrame& shown, const MessageContext& context, MessageBuffer& out_buffer) {
  RISORIUS_CHECK(context.names.size() == shown.aus.count);
  MapWriter out(out_buffer, bound(context, 32), kHeaderEntries + 5);
  write_header(out, shown.aus.header, context);
  out.key("kind");
  out.text(word_of(shown.aus.kind));
  out.key("origin");
  out.text(word_of(shown.origin));
  write_aus(out, shown.aus, context);
  out.finish();
}

void encode_continuation(const Continuation& continuation, const MessageContext& context, MessageBuffer& out_buffer) {
  RISORIUS_CHECK(context.names.size() == continuation.au_count);
  MapWriter out(out_buffer, 2 * bound(context, 5 + 5 * continuation.step_count),
                kHeaderEntries + 3);  // names stand twice
  write_header(out, continuation.header, context);
  out.key("ahead_ns");
  out.array(continuation.step_count);
  for (std::uint32_t s = 0; s < continuation.step_count; ++s) out.integer(continuation.ahead_ns[s]);
  const auto write_table = [&](const auto& table) {
    out.map(continuation.au_count);
    for (std::uint32_t i = 0; i < continuation.au_count; ++i) {
      out.key(context.names[i]);
      out.array(continuation.step_count);
      for (std::uint32_t s = 0; s < continuation.step_count; ++s) out.number(table[s][i]);
    }
  };
  out.key("au");
  write_table(continuation.intensity);
  out.key("standard_deviation");
  write_table(continuation.standard_deviation);
  out.finish();
}

}  // namespace risorius
