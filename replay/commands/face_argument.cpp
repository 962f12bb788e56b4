#include "replay/commands/face_argument.h"

#include <filesystem>

#include "capture/errors.h"
#include "replay/progress_line.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/ict_face.h"

namespace risorius {

FaceModel face_of_argument(const std::string& name_or_folder) {
  if (name_or_folder == "builtin") return builtin_face();
  if (!std::filesystem::is_directory(name_or_folder)) {
    throw UserError("--face", shown(name_or_folder) + " is no folder",
                    "give builtin, or the folder FaceXModel of the ICT-FaceKit release");
  }
  ProgressLine progress("reading the face", "files");
  std::uint64_t files = 0;
  FaceModel face = load_ict_face(name_or_folder, [&](std::size_t done, std::size_t of) {
    files = of;
    progress.show(done, of);
  });
  progress.finish(files);
  return face;
}

}  // namespace risorius
