// What the header, the parameters and the length of a C3D file together say about its points. They often contradict
// each other; every choice between them is made here, with a warning.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/marker_set.h"
#include "replay/takes/c3d_header.h"
#include "replay/takes/c3d_parameters.h"
#include "replay/takes/take.h"

namespace risorius {

struct C3dLayout {
  C3dProcessor processor = C3dProcessor::kIntel;
  MarkerSet markers;
  bool float_points = true;
  double scale = 1;               ///< units per count of integer points; 1 for float points
  std::uint64_t data_offset = 0;  ///< of the first frame, in bytes
  std::size_t frame_bytes = 0;    ///< points and analog values of one frame
  std::uint64_t frame_count = 0;  ///< whole frames that the file holds, at least 1
};

struct C3dSource {
  std::string place;  ///< for messages: the file's path
  std::uint64_t file_bytes = 0;
  C3dProcessor processor = C3dProcessor::kIntel;
  const C3dHeader& header;
  const C3dParameters& parameters;
  const TakeOptions& options;
};

/// Appends to `warnings`. Throws UserError (place, field, value, remedy) where no points can be had.
C3dLayout resolve_c3d_layout(const C3dSource& source, std::vector<std::string>& warnings);

}  // namespace risorius
