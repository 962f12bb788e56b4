// How fast, how long and how far a face moves: the table that drives the synthetic performer. The one that ships
// (dynamics.json, compiled in) is written by `risorius perform-fit` from a real recording; nothing in it is set by
// hand.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "replay/performer/posture_table.h"
#include "replay/performer/random.h"

namespace risorius {

struct LogNormal {
  double median = 1;
  double sigma = 0.5;  ///< of the logarithm, 0 to 2

  /// Cut off at 2.5 sigma.
  double draw(Random& random) const noexcept;
  /// Of the distribution as cut off, for 0 < share < 1 (approximately: the cut is ignored).
  double p90() const noexcept;
};

/// A slow or fast wandering of intensities about their course.
struct Wander {
  double deviation = 0;        ///< standard deviation of the intensity
  double time_constant_s = 1;  ///< after which it has forgotten where it was
};

/// How the ways to a posture differ from each other, and what happens while it is held.
struct Timing {
  double lag_s = 0;              ///< standard deviation: when an AU sets out, against the one that leads
  double pace = 0;               ///< standard deviation of the logarithm of its way's duration against the leader's
  double split_probability = 0;  ///< that a way is made in two steps
  double split_share = 0.5;      ///< of the way, made by the first step
  double split_gap = 0.5;        ///< from the first step's fastest moment to the second's, in durations of the way
  double shifts_per_second = 0;  ///< small changes of a held posture
  double shift_renewal = 0;      ///< how much of the posture a shift renews, 0 to 1: its correlation is sqrt(1 - r^2)
  double apex_shift = 0;         ///< standard deviation of the logarithm of a held AU's level over the shifts
  double persistence = 0;        ///< correlation of a posture with the one before
};

struct Dynamics {
  std::string source, licence, made_by;
  LogNormal onset_s, hold_s, offset_s;  ///< of one action
  LogNormal rest_s;                     ///< from one action's letting go to the next action
  LogNormal peak;                       ///< cut off at 1
  double repeat_probability = 0;        ///< that an action is done again after its rest
  double onset_skew = 1, offset_skew = 1;
  double side_lag_s = 0, side_gain = 0;  ///< standard deviations: left against right; gain of the logarithm
  Timing timing;
  double follower_gain = 1;  ///< of the AUs that the postures bring along, times the levels of the table
  Wander micro_motion, rest_drift;
  PostureTable postures;
};

/// Throws UserError naming `place`, field, value and remedy.
Dynamics parse_dynamics(std::string_view json, const std::string& place);
Dynamics load_dynamics(const std::filesystem::path& path);
const Dynamics& shipped_dynamics();
std::string dynamics_to_json(const Dynamics& dynamics);

}  // namespace risorius
