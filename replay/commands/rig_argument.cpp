#include "replay/commands/rig_argument.h"

#include "solve/faces/builtin_face.h"

namespace risorius {

Rig rig_of_argument(const std::string& name_or_path) {
  return name_or_path == "builtin" ? builtin_rig() : load_rig(name_or_path);
}

}  // namespace risorius
