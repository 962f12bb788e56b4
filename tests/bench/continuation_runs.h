// Takes as continuations meet them (AU frames at the source's own sample times, clean or solved from a performed face),
// and what a model predicts on them, scored at these times only: an upsampled past would leak the future.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "generate/continuation.h"
#include "replay/corpus/au_recording.h"
#include "replay/evaluation/continuation_score.h"

namespace risorius::bench {

struct ContinuationTake {
  std::string name;
  std::vector<std::string> aus;
  std::vector<double> upper_bounds;
  double rate_hz = 0;
  std::vector<AuFrame> frames;      ///< sequence: the source's frame number
  std::vector<std::size_t> moving;  ///< AUs with p99 - p1 > 0.1
};

/// The recording itself.
ContinuationTake clean_take(const AuRecording& recording);
/// The recording on the built-in face, its markers with 0.2 mm of noise and 3 % occlusions, repaired and solved.
ContinuationTake solved_take(const AuRecording& recording, std::uint64_t seed);

/// The multiples of the source's frame time that are nearest, upwards in between.
std::vector<double> native_horizons_ms(const std::vector<double>& horizons_ms, double rate_hz);

/// One prediction beside what came, for pictures.
struct Prediction {
  std::size_t frame = 0;
  Continuation continuation;
};

struct ContinuationRun {
  ContinuationScore score;
  std::vector<Prediction> predictions;
};

ContinuationRun run_continuation(const ContinuationTake& take, std::unique_ptr<ContinuationModel> model,
                                 const std::vector<double>& horizons_ms);

}  // namespace risorius::bench
