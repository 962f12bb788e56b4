// The neutral of a take, found with its intensities: the rig's, shifted by what the solved frames leave of each marker
// on average,
//     n_m = (sum_f c v_fm r_fm) / (sum_f c v_fm + s^2 / s_n^2)
// with r the residual from the rig's own neutral and c counting frames within 2 s as one, because what the model cannot
// do lasts. It minimises eq. (4) of solve/README.md over n for given intensities, with || n ||^2 s^2 / s_n^2 added. The
// stabilisers' rigid motion is taken out of it: that is the head's.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/joint/joint_frame.h"
#include "solve/joint/joint_window.h"
#include "solve/rigs/rig.h"

namespace risorius {

class TakeNeutral {
 public:
  /// `deviation_mm` > 0: how far a marker's rest lies from the rig's neutral, per axis, one standard deviation.
  TakeNeutral(const Rig& start, double deviation_mm) : start_(start), rig_(start), deviation_mm_(deviation_mm) {}

  /// One step, from frames whose y was measured from `rig()`; afterwards they are measured from the new one.
  /// `step_s`: usual time between frames. Returns the farthest move of a marker in mm.
  double update(std::vector<JointFrame>& frames, const JointState& state, double variance_mm2, double step_s);

  /// The start with the neutral found so far.
  const Rig& rig() const noexcept { return rig_; }

 private:
  Rig start_, rig_;
  double deviation_mm_;
};

}  // namespace risorius
