// The check of a rig as a picture: which AUs look like which to the markers, and how certain each intensity is.
#pragma once

#include "replay/picture/canvas.h"
#include "solve/rigs/rig_check.h"

namespace risorius {

Canvas draw_rig_check(const RigCheck& check, const std::string& title);

}  // namespace risorius
