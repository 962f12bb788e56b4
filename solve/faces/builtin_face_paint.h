// Colours of the built-in face, for pictures: skin, brows, lips, lashes, eyes, teeth.
#pragma once

#include <Eigen/Core>

#include "solve/faces/builtin_head_mesh.h"

namespace risorius {

/// sRGB, 0 to 1: 3 x V. `mesh` is the head at rest, before it takes an identity.
Eigen::Matrix3Xd builtin_colours(const HeadMesh& mesh);

}  // namespace risorius
