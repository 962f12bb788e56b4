// A stretch of a take as the calibration of a rig reads it: the rig's markers by name, measured positions only.
#pragma once

#include <string>

#include "replay/takes/take.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/rig_calibrate.h"

namespace risorius {

/// Frames of `range` (the whole take without one). Throws UserError: a range beyond the take, more than 20000 frames,
/// or less than half of the rig's markers in the take.
CalibrationRecording calibration_recording_of(TakeReader& take, const TakeRange& range, const Rig& rig,
                                              const std::string& au);

}  // namespace risorius
