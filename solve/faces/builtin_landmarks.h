// The named places of the built-in face: the landmarks of landmark_map.h and four layouts of markers. All lie on the
// skin; right ones are the exact mirror images of left ones.
//   iemocap55   55 markers, named as in IEMOCAP
//   animface41  41 markers, named as in AnimFace's takes
//   bu4dfe83    83 landmarks in the groups of BU-4DFE: {left,right}_eye_1..8, {left,right}_brow_1..10, nose_1..12,
//               mouth_outer_1..12, mouth_inner_1..8, contour_1..15
//   ibug68      68 landmarks, named by their number, "0" to "67"
#pragma once

#include "solve/faces/builtin_head_mesh.h"
#include "solve/faces/face_model.h"

namespace risorius {

/// Fills landmarks and layouts. `mesh` is the head at rest, before it takes an identity.
void add_builtin_landmarks(const HeadMesh& mesh, FaceParts& parts);

}  // namespace risorius
