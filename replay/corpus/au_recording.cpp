#include "replay/corpus/au_recording.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "capture/errors.h"
#include "replay/performer/action_statistics.h"
#include "replay/takes/au_timeline.h"
#include "replay/takes/face_series.h"

namespace risorius {
namespace {

constexpr double kRestShare = 0.05;
constexpr float kMostIntensityF = 1.2F;

std::vector<double> observed_column(const AuSeries& series, std::size_t k) {
  std::vector<double> values;
  for (const auto& row : series.intensities) {
    if (!std::isnan(row[k])) values.push_back(row[k]);
  }
  return values;
}

}  // namespace

AuRecording record_of(std::string take, AuSeries series, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) throw std::invalid_argument("record_of: the rate is not above 0");
  AuRecording recording{std::move(take), {{}, series.frames, {}}, {}, rate_hz, {}};
  recording.series.intensities.resize(series.frames.size());
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    const std::vector<double> observed = observed_column(series, k);
    if (observed.empty()) continue;
    const double rest = std::max(0.0, quantile_of(observed, kRestShare));
    const double most = quantile_of(observed, 1) - rest;
    if (most > kMostIntensityF) {
      recording.warnings.push_back(fmt::format("{} reaches {:.2f} over its rest: what is above {:g} is cut",
                                               series.names[k], most, kMostIntensityF));
    }
    recording.series.names.push_back(series.names[k]);
    recording.rest.push_back(rest);
    for (std::size_t f = 0; f < series.frames.size(); ++f) {
      const double value = series.intensities[f][k];
      recording.series.intensities[f].push_back(std::isnan(value) ? value : std::max(0.0, value - rest));
    }
  }
  return recording;
}

AuRecording load_au_recording(const std::filesystem::path& path, std::optional<double> rate_hz) {
  const std::string take = path.stem().string();
  FaceSeries face = load_face_series(path, {.rate_hz = rate_hz});
  if (!face.rate_hz) throw UserError(path.string(), "an AU series says no rate", "give the rate (--rate)");
  if (face.aus.frames.empty()) throw UserError(path.string(), "has no frames", "give a recording with frames");
  AuRecording recording = record_of(take, std::move(face.aus), *face.rate_hz);
  recording.warnings.insert(recording.warnings.begin(), face.warnings.begin(), face.warnings.end());
  return recording;
}

AuMotion motion_of(const AuRecording& recording, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) throw std::invalid_argument("motion_of: the rate is not above 0");
  const AuTimeline timeline(recording.series, recording.rate_hz, recording.series.names);
  const auto frames = static_cast<Eigen::Index>(std::floor(timeline.seconds() * rate_hz + 1e-6)) + 1;
  const auto width = static_cast<Eigen::Index>(recording.series.names.size());
  AuMotion motion{recording.take, recording.series.names, rate_hz, AuMatrix(frames, width)};
  std::vector<double> values(recording.series.names.size());
  for (Eigen::Index f = 0; f < frames; ++f) {
    timeline.at(static_cast<double>(f) / rate_hz, values);
    for (Eigen::Index k = 0; k < width; ++k)
      motion.rows(f, k) = std::clamp(static_cast<float>(values[static_cast<std::size_t>(k)]), 0.0F, kMostIntensityF);
  }
  return motion;
}

}  // namespace risorius
