#include "bench/solve_case.h"

#include <cmath>
#include <stdexcept>

#include "replay/performer/performer.h"
#include "replay/pipeline/neutral.h"
#include "replay/takes/au_timeline.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/ict_face.h"
#include "solve/faces/landmark_map.h"
#include "solve/faces/rig_fit.h"

namespace risorius::bench {
namespace {

constexpr double kNeutralSeconds = 0.5;

PerformerOptions performer_options(const SolveCaseOptions& options) {
  PerformerOptions performer;
  performer.seed = options.seed;
  performer.rate_hz = options.rate_hz;
  performer.seconds = options.seconds;
  performer.noise_mm = options.noise_mm;
  performer.occlusion_share = options.occlusion_share;
  performer.false_track_share = 0;
  performer.script = options.script;
  if (options.is_perturbed) performer.perturb = PerturbOptions::like_people();
  return performer;
}

/// The generic face with this person's neutral: what an actor's first recording gives.
Rig rig_of_person(const Rig& generic, const SolveCaseOptions& options) {
  PerformerOptions performer = performer_options(options);
  performer.seconds = kNeutralSeconds;
  performer.occlusion_share = 0;
  performer.head_motion = 0;
  performer.micro_motion = 0;
  const AuSeries rest{
      .names = generic.au_names(), .frames = {0}, .intensities = {std::vector<double>(generic.au_count(), 0.0)}};
  PerformerTake take(Performance(generic, AuTimeline(rest, options.rate_hz, generic.au_names()), performer));
  Rig rig = generic;
  rig.neutral_mm = neutral_of(take, 0, static_cast<std::uint64_t>(kNeutralSeconds * options.rate_hz) - 1).position_mm;
  return rig;
}

SolveCase record(const std::string& name, const Rig& generic, Performance performance,
                 const SolveCaseOptions& options) {
  SolveCase made{.name = name,
                 .rig = options.is_perturbed ? rig_of_person(generic, options) : generic,
                 .markers = performance.marker_set(),
                 .rate_hz = options.rate_hz,
                 .frames = {},
                 .truth = {}};
  made.truth.resize(static_cast<Eigen::Index>(performance.frame_count()),
                    static_cast<Eigen::Index>(generic.au_count()));
  MarkerFrame observed, clean;
  AuFrame truth;
  while (performance.next(observed, truth, clean)) {
    for (Eigen::Index k = 0; k < made.truth.cols(); ++k) {
      made.truth(static_cast<Eigen::Index>(made.frames.size()), k) = truth.intensity[static_cast<std::size_t>(k)];
    }
    made.frames.push_back(observed);
  }
  add_outliers(made, options.outlier_share, options.seed);
  return made;
}

}  // namespace

SolveCase make_solve_case(const std::string& name, const Rig& generic, const SolveCaseOptions& options) {
  return record(name, generic, Performance(generic, performer_options(options)), options);
}

SolveCase make_solve_case(const std::string& name, const Rig& generic, const AuSeries& series, double series_rate_hz,
                          const SolveCaseOptions& options) {
  return record(
      name, generic,
      Performance(generic, AuTimeline(series, series_rate_hz, generic.au_names()), performer_options(options)),
      options);
}

AuSeries one_by_one(const std::vector<std::string>& names) {
  constexpr int kFrames = 30;
  AuSeries series{.names = names, .frames = {}, .intensities = {}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (int f = 0; f < kFrames; ++f) {
      series.frames.push_back(series.frames.size());
      series.intensities.emplace_back(names.size(), 0.0);
      series.intensities.back()[i] = 0.5 - 0.5 * std::cos(2 * std::acos(-1.0) * f / kFrames);
    }
  }
  return series;
}

void add_outliers(SolveCase& with, double share, std::uint64_t seed) {
  Random random(seed, 77);
  for (MarkerFrame& frame : with.frames) {
    for (std::size_t m = 0; m < frame.count; ++m) {
      if (frame.state[m] != MarkerState::kMeasured || !random.chance(share)) continue;
      Eigen::Vector3d direction;
      for (double& coordinate : direction) coordinate = random.gaussian();
      const Eigen::Vector3f shift = (random.uniform(5, 40) * direction.normalized()).cast<float>();
      Position& p = frame.position_mm[m];
      p = {p.x + shift.x(), p.y + shift.y(), p.z + shift.z()};
    }
  }
}

Rig rig_at_layout(const std::optional<std::filesystem::path>& ict_folder, const std::string& layout) {
  const FaceModel builtin = builtin_face();
  if (!ict_folder && layout == kBuiltinLayout) return builtin_rig_of(builtin);
  const std::vector<NamedPlace>* places = builtin.find_layout(layout);
  if (places == nullptr) throw std::invalid_argument("the built-in face has no layout " + layout);
  std::vector<std::string> names;
  Eigen::Matrix3Xd neutral_mm(3, static_cast<Eigen::Index>(places->size()));
  for (const NamedPlace& marker : *places) {
    neutral_mm.col(static_cast<Eigen::Index>(names.size())) = builtin.position_mm(marker.place);
    names.push_back(marker.name);
  }
  const LandmarkMap map = find_landmark_map(layout);
  return ict_folder ? fit_rig(load_ict_face(*ict_folder), names, neutral_mm, map).rig
                    : fit_rig(builtin, names, neutral_mm, map).rig;
}

}  // namespace risorius::bench
