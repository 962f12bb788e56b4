#include "bench/continuation_runs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "replay/performer/performer.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/takes/au_timeline.h"
#include "solve/faces/builtin_face.h"

namespace risorius::bench {
namespace {

constexpr double kUpper = 1.2, kNoise_mm = 0.2;

void note_moving(ContinuationTake& take) {
  std::vector<std::vector<double>> rows;
  for (const AuFrame& frame : take.frames) {
    std::vector<double>& row = rows.emplace_back();
    for (std::size_t au = 0; au < take.aus.size(); ++au) {
      row.push_back(frame.state[au] == AuState::kObserved ? frame.intensity[au]
                                                          : std::numeric_limits<double>::quiet_NaN());
    }
  }
  take.moving = aus_that_move(rows);
}

}  // namespace

ContinuationTake clean_take(const AuRecording& recording) {
  const AuSeries& series = recording.series;
  ContinuationTake take{recording.take,    series.names, std::vector<double>(series.names.size(), kUpper),
                        recording.rate_hz, {},           {}};
  for (std::size_t f = 0; f < series.frames.size(); ++f) {
    AuFrame& frame = take.frames.emplace_back();
    frame.header.sequence = series.frames[f];
    frame.header.capture_time_ns = std::llround(static_cast<double>(series.frames[f]) / recording.rate_hz * 1e9);
    frame.count = static_cast<std::uint32_t>(series.names.size());
    frame.kind = AuFrameKind::kMapped;
    frame.status = SolverStatus::kMapped;
    for (std::size_t au = 0; au < series.names.size(); ++au) {
      const double value = series.intensities[f][au];
      frame.state[au] = std::isnan(value) ? AuState::kNotObserved : AuState::kObserved;
      frame.intensity[au] = std::isnan(value) ? 0 : std::min(value, kUpper);
    }
  }
  note_moving(take);
  return take;
}

ContinuationTake solved_take(const AuRecording& recording, std::uint64_t seed) {
  const Rig rig = builtin_rig();
  ContinuationTake take{recording.take, rig.au_names(), {}, recording.rate_hz, {}, {}};
  for (const auto& au : rig.aus) take.upper_bounds.push_back(au.upper_bound);
  PerformerOptions options{.seed = seed, .rate_hz = recording.rate_hz, .seconds = 0, .noise_mm = kNoise_mm};
  Performance performance(rig, AuTimeline(recording.series, recording.rate_hz, rig.au_names()), options);
  FramePipeline pipeline(PipelineOptions{}, rig);
  pipeline.use_marker_set(performance.marker_set());
  MarkerFrame observed, clean;
  AuFrame truth;
  SolvedFrame solved;
  const auto drain = [&] {
    while (pipeline.pop(solved)) take.frames.push_back(solved.aus);
  };
  while (performance.next(observed, truth, clean)) {
    while (!pipeline.push(observed)) drain();
    drain();
  }
  pipeline.flush();
  drain();
  note_moving(take);
  return take;
}

std::vector<double> native_horizons_ms(const std::vector<double>& horizons_ms, double rate_hz) {
  std::vector<double> native;
  for (const double horizon : horizons_ms) {
    const double frames = std::max(1.0, std::floor(horizon * 1e-3 * rate_hz + 0.5));
    native.push_back(frames / rate_hz * 1e3);
  }
  return native;
}

ContinuationRun run_continuation(const ContinuationTake& take, std::unique_ptr<ContinuationModel> model,
                                 const std::vector<double>& horizons_ms) {
  Continuer continuer(std::move(model), {.horizons_ms = horizons_ms});
  ContinuationRun run{ContinuationScore(horizons_ms.size(), take.aus.size()), {}};
  std::map<std::uint64_t, std::size_t> index_of;
  for (std::size_t f = 0; f < take.frames.size(); ++f) index_of[take.frames[f].header.sequence] = f;
  Prediction prediction;
  for (std::size_t f = 0; f < take.frames.size(); ++f) {
    if (!continuer.process(take.frames[f], prediction.continuation)) continue;
    prediction.frame = f;
    run.predictions.push_back(prediction);
    for (std::size_t step = 0; step < horizons_ms.size(); ++step) {
      const auto ahead = static_cast<std::uint64_t>(std::llround(horizons_ms[step] * 1e-3 * take.rate_hz));
      const auto came = index_of.find(take.frames[f].header.sequence + ahead);
      if (came == index_of.end()) continue;
      const AuFrame& actual = take.frames[came->second];
      for (std::size_t au = 0; au < take.aus.size(); ++au) {
        if (actual.state[au] != AuState::kObserved || take.frames[f].state[au] != AuState::kObserved) continue;
        run.score.add(step, au, prediction.continuation.intensity[step][au],
                      prediction.continuation.standard_deviation[step][au], actual.intensity[au]);
      }
    }
  }
  return run;
}

}  // namespace risorius::bench
