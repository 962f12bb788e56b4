// Stretches of a take in which the face may be at rest: still, symmetric, and like what the face keeps coming back to.
// Needs no rig. The head's motion is taken out by the majority of the markers (solve/rigs/marker_rigidity.h).
#pragma once

#include <cstdint>
#include <vector>

#include "capture/frames.h"

namespace risorius {

struct NeutralCandidate {
  std::uint64_t first = 0, last = 0;  ///< frames of the take, both ends included
  double seconds = 0;
  double motion_mm = 0;     ///< rms per marker about its mean
  double asymmetry_mm = 0;  ///< rms to its mirror image, beyond that of the most symmetric stretch
  double frequency = 0;     ///< share of the take's time in which the face is within 1.5 mm rms of it
  double score = 0;         ///< 0 to 1
};

struct NeutralSearchOptions {
  double window_s = 0.5;      ///< a stretch is at least this long, 0.1 to 10
  double longest_s = 3;       ///< and at most this long
  double still_mm = 0.4;      ///< motion at which the score has fallen to 1/e, > 0
  double symmetric_mm = 1.5;  ///< asymmetry at which it has, > 0
  double alike_mm = 1.5;      ///< rms per marker within which two faces are the same, > 0
  std::size_t most = 5;       ///< candidates
};

/// Best first. A marker is compared where half of a window's frames with a face see it; windows are, where they see 70
/// % of the markers that windows usually see. None where no window does. Frames of one marker set.
std::vector<NeutralCandidate> neutral_candidates(const std::vector<MarkerFrame>& frames,
                                                 const NeutralSearchOptions& options = {});

}  // namespace risorius
