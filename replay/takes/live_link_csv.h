// Face shapes as the Live Link Face app records them: `Timecode,BlendShapeCount,EyeBlinkLeft,...,RightEyeRoll`, one
// line per frame. No rate stands in the file: it follows from the steps of the timecodes HH:MM:SS:FF.sss, whose FF may
// count in a finer base than the frames (30 frames per second as 0, 2, 4, ... 58). Holes are steps of several frames.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "replay/takes/au_series.h"

namespace risorius {

/// The app's rotations of head and eyes, in the order of its packets.
inline constexpr std::array<std::string_view, 9> kLiveLinkAngles{"headYaw",     "headPitch",     "headRoll",
                                                                 "leftEyeYaw",  "leftEyePitch",  "leftEyeRoll",
                                                                 "rightEyeYaw", "rightEyePitch", "rightEyeRoll"};

struct LiveLinkTake {
  AuSeries shapes;  ///< ARKit's names ("eyeBlinkLeft"), whatever order the file has; frame numbers from 0, with holes
  /// Of each frame, as they stand in the file (the app's unit: radians); 0 where it has no such column or value.
  std::vector<std::array<float, kLiveLinkAngles.size()>> angles;
  double rate_hz = 0;
  std::vector<std::string> warnings;
};

/// A shape's column as ARKit names it: "jawOpen" of "JawOpen".
std::string arkit_name(std::string column);

/// Whether the file's first column is `Timecode`. Throws UserError if the file cannot be read.
bool is_live_link_csv(const std::filesystem::path& path);

/// `rate_hz` replaces the rate that the timecodes say, and is needed where they say none (less than a second of them).
/// Values are kept as they are (up to 1.003 occurs). Throws UserError (file, line, column, value, remedy).
LiveLinkTake load_live_link_csv(const std::filesystem::path& path, std::optional<double> rate_hz = std::nullopt);

}  // namespace risorius
