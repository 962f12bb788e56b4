// What travels in the daemon's two kinds of queue. All trivially copyable, so a queue is one block of memory.
#pragma once

#include <array>
#include <cstdint>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/shape_frame.h"
#include "capture/wire/source_event.h"
#include "replay/pipeline/frame_pipeline.h"

namespace risorius {

/// The one admission point: what the I/O thread hands to the pipeline thread. The order of this queue is the order in
/// which everything downstream happens; losses happen before it or at it, never after.
struct AdmittedItem {
  enum class Kind : std::uint8_t {
    kFrame,
    kShapes,
    kMarkerSet,
    kEndOfStream,
    kNeutralCapture,
    kRecordingStarted,  ///< the tracker's own recording
    kRecordingStopped
  };
  Kind kind = Kind::kFrame;
  std::uint32_t stream_id = 0;
  const MarkerSet* marker_set = nullptr;  ///< kMarkerSet: lives as long as the service
  std::int64_t duration_ns = 0;           ///< kNeutralCapture
  std::uint8_t recording_name_size = 0;   ///< kRecordingStarted
  std::array<char, kMaxRecordingNameBytes> recording_name_bytes{};
  MarkerFrame frame;  ///< kFrame
  ShapeFrame shapes;  ///< kShapes
};

/// What the pipeline thread hands to the publisher and to the recorder, in the order of admission.
struct OutputItem {
  enum class Kind : std::uint8_t { kSolved, kMarkerSet, kEndOfStream, kNeutral, kRecordingStarted, kRecordingStopped };
  Kind kind = Kind::kSolved;
  std::uint32_t stream_id = 0;
  const MarkerSet* marker_set = nullptr;
  std::uint8_t recording_name_size = 0;  ///< kRecordingStarted
  std::array<char, kMaxRecordingNameBytes> recording_name_bytes{};
  std::int64_t cleaned_ns = 0, solved_ns = 0;  ///< kSolved: CLOCK_MONOTONIC after these stages; of a shape frame: when
                                               ///< it was taken up, and mapped
  std::uint64_t neutral = 0;                   ///< kSolved: how many live neutrals were taken before it was solved
  SolvedFrame solved;
};

}  // namespace risorius
