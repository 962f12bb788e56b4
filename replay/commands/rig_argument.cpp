#include "replay/commands/rig_argument.h"

#include "replay/commands/take_argument.h"
#include "replay/pipeline/actor.h"
#include "solve/faces/builtin_face.h"

namespace risorius {

Rig rig_of_argument(const std::string& name_or_path) {
  return name_or_path == "builtin" ? builtin_rig() : load_rig_or_actor(name_or_path);
}

RenewedRig with_neutral_of_argument(const Rig& rig, const std::string& neutral, const TakeOptions& options) {
  const NeutralPlace place = parse_neutral_place(neutral);
  const auto take = open_take_or_builtin(place.range.path.string(), options);
  const ChosenNeutral chosen = read_neutral(*take, place);
  return with_neutral(rig, chosen.neutral, chosen.place);
}

}  // namespace risorius
