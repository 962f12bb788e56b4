// A rig as users name it: a rig file, an actor's folder, or "builtin".
#pragma once

#include <string>

#include "solve/rigs/rig.h"

namespace risorius {

/// Throws UserError.
Rig rig_of_argument(const std::string& name_or_path);

}  // namespace risorius
