// The protocol after Gloersen & Federolf 2016 (shared/EVALUATION.md, section 1): white noise on a take, two gaps of
// equal length in K markers chosen at random, after frame 300. Also whole regions behind a hand, and noise that lasts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/marker_csv.h"

namespace risorius::bench {

struct GapTask {
  std::string name;
  std::size_t gap_frames = 0;
  std::size_t markers = 0;  ///< 0: all within region_mm of one
  double region_mm = 0;
  double coloured_noise_mm = 0;  ///< per axis, lasts about 0.25 s
};

inline constexpr double kNoiseMm = 0.1;  ///< white, per axis, of every task
inline constexpr std::size_t kFirstGapFrame = 300;

/// Gaps of 6, 30, 60 and 120 frames in 4 and in 12 markers, a region for half a second, coloured noise.
std::vector<GapTask> gap_tasks(double rate_hz);

/// Why the take cannot be scored on the task; empty if it can.
std::string problem_with(const test::MarkerTake& clean, const GapTask& task);

/// The take with noise and gaps. The same draw is the same for every method.
std::vector<MarkerFrame> draw_gaps(const test::MarkerTake& clean, const GapTask& task, std::uint64_t draw);

}  // namespace risorius::bench
