// A range of motion, pose by pose: is each AU of the rig in the take, how strong, on both sides alike, and is it alone
// at its height? For an actor who stands before the cameras still and can do it again.
#pragma once

#include <string>
#include <vector>

#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

struct PoseCheck {
  std::string au;
  double peak = 0;             ///< the highest intensity that lasts for a tenth of a second
  double peak_s = 0;           ///< when, since the take's first frame
  double other_side_peak = 0;  ///< of the other side's AU; NaN where there is none
  std::string company;         ///< the strongest AU beside it (the other side left out) at its peak
  double company_intensity = 0;
  bool is_seen = false;      ///< it reaches `least_peak`
  bool is_lopsided = false;  ///< it is less than half of the other side
};

/// In the rig's order. Throws UserError where the rig does not know the take's markers, or no frame can be solved.
std::vector<PoseCheck> check_range_of_motion(const Rig& rig, const TakeFrames& take, double least_peak = 0.4,
                                             const AuSolverOptions& options = {.ridge = 5e-3, .l1 = 3e-3});

}  // namespace risorius
