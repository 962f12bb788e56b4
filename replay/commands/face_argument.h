// A face as users name it: "builtin", or the folder of ICT-FaceKit's OBJ files.
#pragma once

#include <string>

#include "solve/faces/face_model.h"

namespace risorius {

/// Shows progress on stderr while files are read. Throws UserError.
FaceModel face_of_argument(const std::string& name_or_folder);

}  // namespace risorius
