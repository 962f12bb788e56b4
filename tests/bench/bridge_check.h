// Drop-outs cut into a take and bridged as the daemon does it: is what is shown continuous at both ends, and how far is
// it from what was lost.
#pragma once

#include "bench/continuation_runs.h"

namespace risorius::bench {

struct BridgeCheck {
  int drop_outs = 0;
  double largest_step_at_start = 0;  ///< of a moving AU, intensity: last frame to 1 ms later
  double largest_step_at_end = 0;    ///< 1 ms before the first frame to that frame
  double mean_jump_without = 0;      ///< the largest AU's jump at the end where the last frame is held
  double mean_error = 0;             ///< of moving AUs while nothing came, against the frames that were cut
  double mean_error_of_hold = 0;
};

/// `draws` drop-outs of so many ms at seeded places, each in a take of its own.
BridgeCheck check_bridges(const ContinuationTake& take, double drop_out_ms, int draws, std::uint64_t seed);

}  // namespace risorius::bench
