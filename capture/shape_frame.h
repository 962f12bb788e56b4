// One frame of a face tracker that tells face shapes instead of markers (ARKit, as Live Link Face sends it).
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "capture/frames.h"

namespace risorius {

/// ARKit's 52 shapes; capture/wire/live_link_codec.h has their names.
inline constexpr std::size_t kFaceShapes = 52;

struct ShapeFrame {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  FrameHeader header;
  bool has_face = false;                   ///< false: the tracker saw no face, and no value means anything
  std::array<float, kFaceShapes> value{};  ///< about 0 to 1; NaN: not told
};

static_assert(std::is_trivially_copyable_v<ShapeFrame>);

}  // namespace risorius
