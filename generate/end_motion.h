// How an AU moves at the end of its past: what a transition has to go on with.
#pragma once

#include "generate/transition.h"

namespace risorius {

struct EndMotion {
  double velocity_per_s = 0, acceleration_per_s2 = 0, jerk_per_s3 = 0;
};

/// At the last row, by a parabola or a cubic through its value that is nearest to the rows before it: of several
/// windows, the one that would have told the rows of this past best, each from those before it. A smooth past so gets a
/// short cubic, a noisy one a long parabola. Two rows give a velocity, one row nothing.
EndMotion end_motion(const AuMatrix& past, Eigen::Index column, double rate_hz) noexcept;

}  // namespace risorius
