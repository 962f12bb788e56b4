// How fast, how long and how far a face moves: the table that drives the synthetic performer. The one that ships
// (dynamics.json, compiled in) is written by `risorius perform-fit` from a real recording; nothing in it is set by
// hand.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

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

/// What else moves when an AU acts.
struct CoAction {
  std::string au;
  double probability = 0;  ///< 0 to 1
  double ratio = 0;        ///< of its peak to the acting AU's
};

struct Dynamics {
  std::string source, licence, made_by;
  LogNormal onset_s, hold_s, offset_s;  ///< of one action
  LogNormal rest_s;                     ///< from one action of the face to the next
  LogNormal peak;                       ///< cut off at 1
  double repeat_probability = 0;        ///< that an action is done again after its rest
  double onset_skew = 1, offset_skew = 1;
  double side_lag_s = 0, side_gain = 0;  ///< standard deviations: left against right; gain of the logarithm
  Wander micro_motion, rest_drift;
  std::map<std::string, std::vector<CoAction>, std::less<>> co_actions;
};

/// Throws UserError naming `place`, field, value and remedy.
Dynamics parse_dynamics(std::string_view json, const std::string& place);
Dynamics load_dynamics(const std::filesystem::path& path);
const Dynamics& shipped_dynamics();
std::string dynamics_to_json(const Dynamics& dynamics);

}  // namespace risorius
