// Tracks of markers before and after repair: x, y and z over time, what was measured, rejected and filled, and the 90 %
// band of what was filled.
#pragma once

#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "replay/picture/canvas.h"

namespace risorius {

/// One row of three plots per marker, in the order given. `before` and `after` have the same frames. Throws UserError
/// for a name that the set does not have.
Canvas repair_picture(const std::vector<MarkerFrame>& before, const std::vector<MarkerFrame>& after,
                      const MarkerSet& set, const std::vector<std::string>& markers);

}  // namespace risorius
