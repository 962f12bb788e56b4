// The neutral face of an actor, out of a stretch of a take in which the face is at rest: the median of each marker's
// measured positions after the head's motion is taken out. Input of fit_rig (solve/rig_fit.h).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "replay/takes/take.h"

namespace risorius {

struct Neutral {
  std::vector<std::string> marker_names;
  Eigen::Matrix3Xd position_mm;               ///< 3 x M, world of the first frame used; NaN where never measured
  std::vector<std::uint64_t> measured_count;  ///< M: frames behind each position
  std::uint64_t frame_count = 0;              ///< frames used
  std::uint64_t skipped_count = 0;            ///< frames with too few markers to align
  double motion_rms_mm = 0;  ///< per marker about its median, the farthest 5 % left out: how still the face was
};

/// Frames `first` to `last` (from 0, inclusive; the take is rewound). Throws UserError: empty or too long range, a
/// range beyond the take, no frame with three markers off one line.
Neutral neutral_of(TakeReader& take, std::uint64_t first, std::uint64_t last);

}  // namespace risorius
