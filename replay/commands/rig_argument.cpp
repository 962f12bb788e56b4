#include "replay/commands/rig_argument.h"

#include "replay/pipeline/actor.h"
#include "solve/faces/builtin_face.h"

namespace risorius {

Rig rig_of_argument(const std::string& name_or_path) {
  return name_or_path == "builtin" ? builtin_rig() : load_rig_or_actor(name_or_path);
}

}  // namespace risorius
