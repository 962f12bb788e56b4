// How a recorded AU series wanders while nothing is done: fast in stretches of rest, slowly in the level of the rest.
#pragma once

#include <vector>

#include "replay/performer/action_statistics.h"
#include "replay/performer/dynamics.h"

namespace risorius {

/// Mean squares of differences; squares from quantiles, because the tails of resting are small actions.
struct WanderMoments {
  double frame = 0, half_second = 0;            ///< of resting AUs, over a frame and over 0.5 s
  double five_seconds = 0, twenty_seconds = 0;  ///< of the resting level
};
WanderMoments wander_moments(const PreparedSeries& series);

/// The wandering that would show these moments if nothing else moved.
Wander micro_motion_of(const WanderMoments& moments, double rate_hz);
Wander rest_drift_of(const WanderMoments& moments);

/// The resting level's changes over five seconds, of all AUs: what drift is compared by.
std::vector<double> rest_drift_steps(const PreparedSeries& series);

/// Power spectral density (1/Hz) of the AUs while they rest, the median over AUs, at `count` frequencies from
/// `rate_hz / (2 count)` to the Nyquist frequency (Welch 1967: half-overlapping Hann windows without their mean). Empty
/// if no AU rests for a window of 2 `count` frames.
struct RestSpectrum {
  std::vector<double> frequency_hz, density;
};
RestSpectrum rest_spectrum(const PreparedSeries& series, std::size_t count);

}  // namespace risorius
