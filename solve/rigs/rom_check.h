// A range of motion, pose by pose: is each AU of the rig in the take, how strong, on both sides alike, and is it alone
// at its height?
#pragma once

#include <vector>

#include "solve/rigs/pose_check.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

/// Solved as the live service does. In the rig's order; times since the take's first frame. Throws UserError where the
/// rig does not know the take's markers, or no frame can be solved.
std::vector<PoseCheck> check_range_of_motion(const Rig& rig, const TakeFrames& take, double least_peak = 0.4,
                                             const AuSolverOptions& options = {});

}  // namespace risorius
