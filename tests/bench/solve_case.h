// Takes with exact truth for the accuracy of the solve: a face that may not be the solver's (perturbed) performs on its
// markers, with head motion, 0.2 mm noise and 3 % occlusion; the solver is given the generic rig with this person's own
// neutral, as measured from half a second at rest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "replay/performer/performer_script.h"
#include "replay/takes/au_series.h"
#include "solve/rigs/rig.h"

namespace risorius::bench {

struct SolveCaseOptions {
  bool is_perturbed = false;  ///< PerturbOptions::like_people()
  double noise_mm = 0.2;
  double occlusion_share = 0.03;
  double outlier_share = 0;  ///< of the visible samples: moved by 5 to 40 mm
  double rate_hz = 120;
  double seconds = 20;
  std::uint64_t seed = 11;
  ScriptKind script = ScriptKind::kMixed;
};

struct SolveCase {
  std::string name;
  Rig rig;  ///< as the solver knows the actor
  MarkerSet markers;
  double rate_hz = 0;
  std::vector<MarkerFrame> frames;
  Eigen::MatrixXd truth;  ///< frames x K
};

SolveCase make_solve_case(const std::string& name, const Rig& generic, const SolveCaseOptions& options);
/// Driven by a recorded AU series instead of a script.
SolveCase make_solve_case(const std::string& name, const Rig& generic, const AuSeries& series, double series_rate_hz,
                          const SolveCaseOptions& options);

/// Each AU alone, one after the other: up to 1 and back in half a second. At 60 Hz.
AuSeries one_by_one(const std::vector<std::string>& names);

/// Displaces that share of the measured samples by 5 to 40 mm in a direction of its own.
void add_outliers(SolveCase& with, double share, std::uint64_t seed);

/// The built-in face or ICT's (folder of its OBJ files; none: the built-in one) at the marker places of a layout of the
/// built-in face.
Rig rig_at_layout(const std::optional<std::filesystem::path>& ict_folder, const std::string& layout);

}  // namespace risorius::bench
