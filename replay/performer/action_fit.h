// What single actions of a recorded AU series show of a face's dynamics: ways' durations, skews, sides.
#pragma once

#include <vector>

#include "replay/performer/action_statistics.h"
#include "replay/performer/dynamics.h"

namespace risorius {

/// Sets onset, hold, offset, rest and peak as the actions show them one by one, skews, and the sides' lag and gain.
/// What thresholds and overlapping actions do to them is left to simulated moments.
void fit_single_actions(const PreparedSeries& series, const std::vector<AuAction>& actions, Dynamics& dynamics);

}  // namespace risorius
