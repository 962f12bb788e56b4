// ICT-FaceKit's generic face (Li et al., Learning Formation of Physically-Based Face Attributes, CVPR 2020) from the
// published OBJ files: generic_neutral_mesh.obj and one OBJ per expression, 26,719 vertices in centimetres, x to the
// subject's left, y up, z out of the face. Vertices 0 to 9408 are the face; markers are registered to these only.
// The files are not part of this project. AU columns are sums of the published shapes (recipe table in the .cpp).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "solve/faces/face_model.h"

namespace risorius {

inline constexpr int kIctVertexCount = 26719;
inline constexpr int kIctFaceVertexCount = 9409;

/// Called after each file that was read.
using LoadProgress = std::function<void(std::size_t files_read, std::size_t files_in_all)>;

/// Reads with OpenMesh; takes about two seconds. Throws UserError naming every file that is missing, or the file that
/// is not ICT-FaceKit's mesh.
FaceModel load_ict_face(const std::filesystem::path& folder, const LoadProgress& progress = {});

/// The expression files that load_ict_face reads, without ".obj".
std::vector<std::string> ict_shape_names();

}  // namespace risorius
