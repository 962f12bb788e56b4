// A rig as users name it: a rig file, an actor's folder, or "builtin"; and the neutral of a session for it.
#pragma once

#include <string>

#include "replay/pipeline/rig_neutral.h"
#include "replay/takes/take.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// Throws UserError.
Rig rig_of_argument(const std::string& name_or_path);

/// The rig with the neutral of a take: "TAKE:FROM-TO", "TAKE" or "TAKE:auto". Throws UserError.
RenewedRig with_neutral_of_argument(const Rig& rig, const std::string& neutral, const TakeOptions& options = {});

}  // namespace risorius
