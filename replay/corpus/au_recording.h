// A recorded face as the generators learn from it and are measured on it: AUs by name over their resting level, at the
// source's own sample times (AuRecording) or resampled to one rate (AuMotion).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "generate/transition.h"
#include "replay/takes/au_series.h"

namespace risorius {

/// Rate of the corpora, frames per second.
inline constexpr double kCorpusRateHz = 120;

struct AuRecording {
  std::string take;          ///< the file's name without folder and ending
  AuSeries series;           ///< at the source's own frames; intensities over `rest`, not below 0
  std::vector<double> rest;  ///< per AU: the intensity that was taken off, its 5 % quantile
  double rate_hz = 0;        ///< of series.frames
  std::vector<std::string> warnings;
};

/// The same at a uniform rate; holes are bridged.
struct AuMotion {
  std::string take;
  std::vector<std::string> names;
  double rate_hz = 0;
  AuMatrix rows;  ///< frames x names
};

/// Reads a Live Link Face CSV (its shapes become AUs by the shipped table, actions only) or an AU CSV, which needs
/// `rate_hz`. Throws UserError (file, line, column, value, remedy).
AuRecording load_au_recording(const std::filesystem::path& path, std::optional<double> rate_hz = std::nullopt);

/// Takes the resting level off. `rate_hz` > 0. AUs that the series never observes are left out.
AuRecording record_of(std::string take, AuSeries series, double rate_hz);

/// By monotone cubics between the samples (AuTimeline). Throws std::invalid_argument.
AuMotion motion_of(const AuRecording& recording, double rate_hz = kCorpusRateHz);

}  // namespace risorius
