// Measures on a recorded AU series what the performer's postures are made of: which intensities go together, how the
// AUs' ways differ within one change of posture, and how steadily postures are held.
#pragma once

#include <vector>

#include "replay/performer/action_statistics.h"
#include "replay/performer/dynamics.h"

namespace risorius {

/// Sides are taken together (their mean). Correlations are shrunk by a tenth towards none: the recording has some
/// hundred independent postures.
PostureTable fit_postures(const PreparedSeries& series);

/// Lags, paces, splits, shifts and what they do to a held apex; persistence and renewal are left as they are (they come
/// from simulated moments).
Timing fit_timing(const PreparedSeries& series, const std::vector<AuAction>& actions);

/// Mean autocorrelation of the AUs' ranks after this time.
double posture_memory(const PreparedSeries& series, double lag_s);

/// An AU without its side; jaw left and right stay two, because they are opposites.
std::string base_of_column(const std::string& name);

}  // namespace risorius
