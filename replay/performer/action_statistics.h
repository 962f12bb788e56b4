// What the actions of a face are like in a recorded or performed AU series: one estimator for both. The series is put
// on a 30 Hz grid, smoothed over three samples, and its resting level (a low percentile of the seconds around) is taken
// off. An action of an AU goes from where it rises over a low threshold to where it falls below it again, if it reaches
// a high one between. Lids (AU43, AU45) are left out: they follow the gaze.
#pragma once

#include <cstddef>
#include <vector>

#include "replay/takes/au_series.h"

namespace risorius {

struct ActionOptions {
  double grid_hz = 30;
  double low = 0.075, high = 0.15;  ///< thresholds over the resting level
  double rest_share = 0.2;          ///< the percentile that is the resting level, 0 to 1
  double rest_window_s = 10;        ///< to either side
};

struct AuAction {
  std::size_t au = 0;  ///< index into the prepared names
  double begin_s = 0, end_s = 0;
  double peak = 0;                   ///< over the resting level
  double peak_velocity = 0;          ///< per second, the largest of onset and offset
  double onset_s = 0, offset_s = 0;  ///< from 10 % to 90 % of the peak and back, times 1.65 (minimum jerk's 0 to 1)
  double hold_s = 0;                 ///< above 90 % of the peak
};

/// A series on the grid, over its rest.
struct PreparedSeries {
  std::vector<std::string> names;
  double rate_hz = 30;
  std::vector<std::vector<double>> rows;  ///< frames x names, >= 0
  std::vector<std::vector<double>> rest;  ///< frames x names: what was taken off
};

/// Throws std::invalid_argument for an empty series.
PreparedSeries prepare_series(const AuSeries& series, double rate_hz, const ActionOptions& options = {});
/// Part of a prepared series.
PreparedSeries part_of(const PreparedSeries& series, std::size_t first, std::size_t count);

/// Sorted by AU, then time. Actions that the series' ends cut are left out.
std::vector<AuAction> find_actions(const PreparedSeries& series, const ActionOptions& options = {});

/// What is compared between real and performed faces, over all AUs.
struct ActionDistributions {
  std::vector<double> peak_velocity;  ///< per second
  std::vector<double> duration_s;
  std::vector<double> rest_to_rest_s;  ///< from the end of an action to the end of the next one of the same AU
};
ActionDistributions distributions_of(const std::vector<AuAction>& actions);
void append(ActionDistributions& to, const ActionDistributions& more);

/// The share-quantile (0 to 1) by linear interpolation; 0 of nothing.
double quantile_of(std::vector<double> values, double share);

}  // namespace risorius
