// The built-in face: a procedural human head (about 11,800 vertices, symmetric, mm; x to the subject's left, y up, z
// out of the face, origin between the ears) with lids and lips that part, eyeballs, teeth and mouth; AU shapes from a
// table of muscles (facial_muscles.h); the landmarks and marker layouts of builtin_landmarks.h. It needs no file.
#pragma once

#include "solve/faces/face_identity.h"
#include "solve/faces/face_model.h"
#include "solve/rigs/rig.h"

namespace risorius {

inline constexpr const char* kBuiltinLayout = "iemocap55";

/// Built anew by each call, in tenths of a second; the same identity always gives the same face. Parameters outside
/// their ranges are allowed, but then the face may fold.
FaceModel builtin_face(const FaceIdentity& identity = {});

/// The rig of the built-in face's 55 markers, held still by forehead, head band and nose bridge.
Rig builtin_rig();

/// Which AUs become columns: those that markers can tell apart (all but AU23), or every one, for pictures.
enum class RigColumns { kSolvable, kAll };

/// The same for a face at hand, which must have the layout "iemocap55". AUs that move no marker by 0.3 mm are left out.
Rig builtin_rig_of(const FaceModel& builtin, RigColumns columns = RigColumns::kSolvable);

}  // namespace risorius
