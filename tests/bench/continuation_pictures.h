// build/bench/continuation.png: error over horizon of all models, and courses with what was predicted on the way.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/continuation_runs.h"

namespace risorius::bench {

struct HorizonCurve {
  std::string model;
  std::vector<double> mae;  ///< one per horizon
};

struct HorizonPanel {
  std::string title;
  std::vector<double> horizons_ms;
  std::vector<HorizonCurve> curves;
};

/// `example` and `predictions`: of one take and the default model, shown on its two AUs that move most.
void draw_continuation(const std::vector<HorizonPanel>& panels, const ContinuationTake& example,
                       const std::vector<Prediction>& predictions, const std::filesystem::path& path);

}  // namespace risorius::bench
