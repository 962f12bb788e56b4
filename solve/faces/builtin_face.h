// The built-in face: the front of a procedural head (about 3,200 vertices, symmetric, mm; x to the subject's left, y
// up, z out of the face, origin between the ears), AU shapes written from anatomy (builtin_face_shapes.h), the
// landmarks of landmark_map.h and a layout of 55 markers named as in IEMOCAP ("iemocap55"). It needs no file.
#pragma once

#include "solve/faces/face_model.h"
#include "solve/rigs/rig.h"

namespace risorius {

inline constexpr const char* kBuiltinLayout = "iemocap55";

/// Built anew by each call, in tens of milliseconds; always the same.
FaceModel builtin_face();

/// The rig of the built-in face's 55 markers, held still by forehead, head band and nose bridge.
Rig builtin_rig();

/// The same for a face at hand.
Rig builtin_rig_of(const FaceModel& builtin);

}  // namespace risorius
