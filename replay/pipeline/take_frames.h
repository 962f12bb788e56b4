// A take in memory, despiked, for what has to look at it more than once: the refinement and the checks of rigs.
#pragma once

#include <string>

#include "replay/takes/take.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

/// Every frame, or evenly chosen ones where there are more than `most`. Throws UserError for a take without frames.
TakeFrames take_frames_of(TakeReader& take, const std::string& place, std::size_t most = 6000);

}  // namespace risorius
