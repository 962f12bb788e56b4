// What a source hands on, in the order in which it happened. Plain values of fixed size: handing on allocates nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/shape_frame.h"

namespace risorius {

/// The end of a sender's run, as far as its protocol tells.
struct EndOfStream {
  std::uint32_t session = 0;
  std::uint64_t frames_sent = 0;    ///< 0 also where the protocol does not say
  std::uint64_t last_sequence = 0;  ///< means nothing if frames_sent is 0
};

enum class SourceEventKind : std::uint8_t {
  kNewSession,
  kMarkerSet,  ///< for a source of shapes: a set without names, which states the rate
  kFrame,
  kEndOfStream,
  kRecordingStarted,  ///< the tracker records: the frames after this event belong to its recording
  kRecordingStopped,
  kShapes,  ///< a frame at the level of AUs: it enters after the solve
};

/// The longest name of a tracker's recording that is kept, in bytes.
inline constexpr std::size_t kMaxRecordingNameBytes = 63;

struct SourceEvent {
  SourceEventKind kind = SourceEventKind::kFrame;
  std::uint32_t session = 0;
  const MarkerSet* set = nullptr;  ///< kMarkerSet: unchanging, lives as long as the source
  EndOfStream end;                 ///< kEndOfStream
  std::uint8_t recording_name_size = 0;
  std::array<char, kMaxRecordingNameBytes> recording_name_bytes{};
  MarkerFrame frame;  ///< kFrame
  ShapeFrame shapes;  ///< kShapes

  /// kRecordingStarted, kRecordingStopped: the tracker's name for it; empty if it gives none.
  std::string_view recording_name() const noexcept { return {recording_name_bytes.data(), recording_name_size}; }
  /// Cuts a longer name off.
  void set_recording_name(std::string_view name) noexcept {
    recording_name_size = static_cast<std::uint8_t>(std::min(name.size(), recording_name_bytes.size()));
    std::copy_n(name.data(), recording_name_size, recording_name_bytes.data());
  }
};

}  // namespace risorius
