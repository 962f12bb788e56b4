// The truth of a session as bytes: what was admitted to a stream's pipeline, item by item and in order. Fed to the
// same stages again, Ticks give the same AUs bit for bit. replay/README.md has the layout.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/shape_frame.h"
#include "capture/wire/byte_appender.h"

namespace risorius {

/// The numbers stand in files.
enum class TickKind : std::uint8_t {
  kFrame = 0,
  kShapes = 1,
  kMarkerSet = 2,
  kEndOfStream = 3,
  kNeutralCapture = 4,
  kRecordingStarted = 5,  ///< the tracker's own recording
  kRecordingStopped = 6,
};

/// What a Tick says; beside `kind` only what belongs to it.
struct SessionTick {
  TickKind kind = TickKind::kFrame;
  MarkerFrame frame;             ///< kFrame
  ShapeFrame shapes;             ///< kShapes
  MarkerSet set;                 ///< kMarkerSet
  std::int64_t duration_ns = 0;  ///< kNeutralCapture
  std::string recording_name;    ///< kRecordingStarted, kRecordingStopped
};

// Each clears `out` first, which keeps its memory: after a few frames encoding allocates nothing.

void encode_tick(const MarkerFrame& frame, ByteAppender& out);
void encode_tick(const ShapeFrame& shapes, ByteAppender& out);
void encode_tick(const MarkerSet& set, ByteAppender& out);
void encode_end_of_stream_tick(ByteAppender& out);
void encode_neutral_tick(std::int64_t duration_ns, ByteAppender& out);
void encode_recording_tick(bool started, std::string_view name, ByteAppender& out);

/// By its head alone.
bool is_marker_set_tick(std::span<const std::byte> bytes) noexcept;
/// False if the bytes are no Tick, or one that no pipeline could have been given.
bool decode_tick(std::span<const std::byte> bytes, SessionTick& tick);

}  // namespace risorius
