// Fits a Dynamics table to a recorded AU series. What can be measured on single actions is (side lag and gain, skew,
// co-activation, rest noise and drift); the distributions of onset, hold, offset, rest and peak are found by simulated
// moments: a range of motion is performed, measured like the recording, and corrected until medians and 90th
// percentiles agree. Everything is seeded.
#pragma once

#include <cstdint>
#include <functional>

#include "replay/performer/action_statistics.h"
#include "replay/performer/dynamics.h"
#include "replay/performer/performer_script.h"

namespace risorius {

struct DynamicsFitOptions {
  std::uint64_t seed = 1;
  int rounds = 40;
  int takes = 24;  ///< performed per round, each as long as the recording
};

/// `progress` (round, of) may be empty. Throws std::invalid_argument if the series has fewer than 30 actions.
Dynamics fit_dynamics(const PreparedSeries& recorded, const DynamicsFitOptions& options = {},
                      const std::function<void(int, int)>& progress = {});

/// A script of these AUs at 30 Hz by a table, with micro-motion and drift, as if it had been recorded.
AuSeries perform_series(const std::vector<std::string>& names, const ScriptOptions& options, const Dynamics& dynamics);

/// The same of a range of motion.
AuSeries perform_range_of_motion(const std::vector<std::string>& names, const Dynamics& dynamics, double seconds,
                                 std::uint64_t seed);

/// What is measured on `takes` such performances, each of `seconds`. As long as the recording that they are compared
/// with: a take cuts its longest intervals off.
ActionDistributions performed_distributions(const std::vector<std::string>& names, const Dynamics& dynamics,
                                            double seconds, int takes, std::uint64_t seed);

}  // namespace risorius
