// A recording as the Live Link Face app writes it, made up from a seed, for tests.
#pragma once

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <string>

#include "capture/wire/live_link_codec.h"

namespace risorius::test {

struct LiveLinkCsvOptions {
  int frames = 120;
  int rate_hz = 60;
  std::set<int> lost;          ///< lines that are not there
  std::set<int> without_face;  ///< lines with empty cells
};

/// What shape `shape` has in frame `frame`: awkward decimals from 0 to 1.003.
inline double shape_value(int frame, int shape) { return 0.5015 + 0.5015 * std::sin(0.37 * frame + 1.3 * shape); }

/// The columns are in the app's order: the right jaw and mouth before the left.
inline void write_live_link_csv(const std::filesystem::path& path, const LiveLinkCsvOptions& options = {}) {
  std::array<int, kFaceShapes> shapes;
  for (int i = 0; i < static_cast<int>(kFaceShapes); ++i) shapes[static_cast<std::size_t>(i)] = i;
  std::swap(shapes[15], shapes[16]);
  std::swap(shapes[21], shapes[22]);
  std::ofstream file(path);
  file << "Timecode,BlendShapeCount";
  for (const int shape : shapes) {
    std::string name(live_link_shape_names()[static_cast<std::size_t>(shape)]);
    name[0] = static_cast<char>(name[0] - 'a' + 'A');
    file << ',' << name;
  }
  for (const char* part : {"Head", "LeftEye", "RightEye"}) file << fmt::format(",{0}Yaw,{0}Pitch,{0}Roll", part);
  for (int frame = 0; frame < options.frames; ++frame) {
    if (options.lost.contains(frame)) continue;
    file << fmt::format("\n10:00:{:02}:{:02}.000,61", frame / options.rate_hz % 60, frame % options.rate_hz);
    const bool face = !options.without_face.contains(frame);
    for (const int shape : shapes) file << (face ? fmt::format(",{:.10f}", shape_value(frame, shape)) : ",");
    for (int i = 0; i < 9; ++i) file << (face ? ",0.1" : ",");
  }
  file << "\n";
}

}  // namespace risorius::test
