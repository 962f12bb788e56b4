// Which markers move with the skull alone? Each frame is laid on the neutral by a robust rigid alignment of ALL
// markers (Geman & McClure's loss, its scale lowered step by step), so that the majority that keeps its shape finds the
// head whatever moves; what is left of each marker says how still it is. Tells stabilisers that move with the face, and
// markers or head bands that slipped.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "capture/rigid_alignment.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

/// The alignment of the majority; not determined with fewer than 3 points of weight > 0 off one line.
/// `least_scale_mm` > 0: distances well below it count fully.
RigidAlignment align_majority(const std::vector<Eigen::Vector3d>& from_mm, const std::vector<Eigen::Vector3d>& to_mm,
                              const std::vector<double>& weights, double least_scale_mm = 0.7);

/// Per marker of the rig: root mean square distance (mm) from the rig's neutral in the frame of the majority; NaN
/// where the take never has it. Throws UserError where the rig does not know the take's markers.
Eigen::VectorXd marker_unrest_mm(const Rig& rig, const TakeFrames& take);

}  // namespace risorius
