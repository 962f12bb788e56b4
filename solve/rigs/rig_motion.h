// A rig as repair can use it: how the markers of this face move, without a word of AUs.
#pragma once

#include <memory>

#include "capture/repair/known_motion.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// One mode per AU.
inline std::shared_ptr<const KnownMotion> motion_of(const Rig& rig) {
  auto motion = std::make_shared<KnownMotion>(KnownMotion{rig.marker_names, rig.neutral_mm, {}});
  for (const RigAu& au : rig.aus) motion->modes_mm.push_back(au.displacement_mm);
  return motion;
}

}  // namespace risorius
