// Which markers hold the head still, where the landmark map does not say.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

/// Four to six markers (all, if there are fewer) out of the third that the AUs move least, spread over the head.
/// Indices.
std::vector<Eigen::Index> choose_stabilisers(const Eigen::Matrix3Xd& neutral_mm, const std::vector<RigAu>& aus);

/// Whether at least three of these markers are not on one line.
bool hold_still(const Eigen::Matrix3Xd& neutral_mm, const Eigen::VectorXd& weights);

}  // namespace risorius
