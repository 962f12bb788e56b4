#include "bench/calibrate_performed.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "replay/performer/performer.h"
#include "replay/pipeline/calibration_recording.h"
#include "replay/pipeline/neutral.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/landmark_map.h"
#include "solve/faces/rig_fit.h"
#include "solve/rigs/rig_calibrate.h"

namespace risorius::bench {
namespace {

constexpr double kRateHz = 120;
constexpr int kFrames = 384;

/// Rest, onset (0.4 s), held for 1.2 s, offset, rest; all zero for the neutral.
AuSeries series_of(const std::vector<std::string>& names, const std::string& au) {
  AuSeries series{.names = names, .frames = {}, .intensities = {}};
  for (int f = 0; f < kFrames; ++f) {
    const double ramp = std::clamp(std::min(f - 72, kFrames - 72 - f) / 48.0, 0.0, 1.0);
    std::vector<double> row(names.size(), 0.0);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == au) row[i] = ramp * ramp * (3 - 2 * ramp);
    }
    series.frames.push_back(static_cast<std::uint64_t>(f));
    series.intensities.push_back(std::move(row));
  }
  return series;
}

/// One actor: the perturbation's seed is the take's, so all takes have the same one.
PerformerTake perform(const Rig& rig, const std::string& au, double noise_mm) {
  const PerformerOptions options{.seed = 5,
                                 .rate_hz = kRateHz,
                                 .seconds = 0,
                                 .noise_mm = noise_mm,
                                 .micro_motion = 0,
                                 .perturb = PerturbOptions::like_people()};
  return PerformerTake(Performance(rig, AuTimeline(series_of(rig.au_names(), au), kRateHz, rig.au_names()), options));
}

}  // namespace

CalibrationError calibrate_performed_takes(double noise_mm) {
  const Rig generic = builtin_rig();
  PerformerTake neutral_take = perform(generic, "", noise_mm);
  const Rig& actor = neutral_take.performance().true_rig();
  const Neutral neutral = neutral_of(neutral_take, 0, kFrames - 1);
  const Rig fitted =
      fit_rig(builtin_face(), neutral.marker_names, neutral.position_mm, find_landmark_map(kBuiltinLayout)).rig;
  std::vector<CalibrationRecording> recordings;
  for (const RigAu& au : actor.aus) {
    PerformerTake take = perform(generic, au.name, noise_mm);
    recordings.push_back(
        calibration_recording_of(take, TakeRange{.path = au.name, .first = {}, .last = {}}, fitted, au.name));
  }
  const Rig calibrated = calibrate_rig(fitted, recordings).rig;
  if (calibrated.marker_names != actor.marker_names) throw std::runtime_error("a marker was lost on the way");
  CalibrationError error;
  double wrong = 0, all = 0;
  for (std::size_t i = 0; i < actor.aus.size(); ++i) {
    const Eigen::Matrix3Xd& truth = actor.aus[i].displacement_mm;
    const double off = (calibrated.aus[i].displacement_mm - truth).squaredNorm();
    wrong += off;
    all += truth.squaredNorm();
    if (off <= error.worst_share * truth.squaredNorm()) continue;
    error.worst_share = off / truth.squaredNorm();
    error.worst_au = actor.aus[i].name;
  }
  error.wrong_share = wrong / all;
  return error;
}

}  // namespace risorius::bench
