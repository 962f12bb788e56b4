// Several recordings of one performance that each lost frames, as one series without holes: seed 003's way (its section
// 5.1). Frames are sorted by number, of a frame that several have the first is kept, and what is still missing is
// interpolated by Lagrange polynomials of degree 1, 2 or 3 through the nearest frames that are there (its equations 5.1
// and 5.2).
#pragma once

#include <span>
#include <vector>

#include "replay/takes/au_series.h"

namespace risorius {

enum class MergeDegree { kLinear = 1, kQuadratic = 2, kCubic = 3 };

struct MergedSeries {
  AuSeries series;                     ///< frame numbers without holes
  std::vector<std::uint64_t> missing;  ///< which no recording had
  std::uint64_t duplicates = 0;        ///< frames that a later recording had again
  std::uint64_t longest_gap = 0;       ///< missing frames in a row
};

/// Throws std::invalid_argument: no recording, different AUs, fewer frames than the degree needs.
MergedSeries merge_recordings(std::span<const AuSeries> recordings, MergeDegree degree);

}  // namespace risorius
