#include "replay/performer/performer_script.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "replay/performer/script_writer.h"

namespace risorius {
namespace {

constexpr double kFirstActionS = 1;  // a take begins with a neutral face, and ends with one
constexpr double kLastRestS = 0.5;
constexpr double kHighest = 1.15;  // an overshoot over 1
// Blinks per minute at rest and in conversation (Bentivoglio et al. 1997).
constexpr double kBlinksAtRest = 17, kBlinksInSpeech = 26;

/// Passages of everything in turn, long enough for each to show what it is.
void write_mixed(ScriptWriter& writer, double until_s) {
  std::size_t place = 0;
  for (double time_s = kFirstActionS; time_s < until_s;) {
    const auto until = [&](double seconds) { return std::min(time_s + seconds, until_s); };
    time_s = std::max(time_s + 0.2, write_expressions(writer, time_s, until(10)));
    time_s = std::max(time_s + 0.2, write_speech(writer, time_s, until(7)));
    time_s = std::max(time_s + 0.2, write_range_of_motion(writer, time_s, until(20), place));
    if (writer.face.chance(0.3)) time_s = std::max(time_s, write_idling(writer, time_s, until(6)));
  }
}

double write_face(ScriptWriter& writer, const ScriptOptions& options) {
  const double until_s = options.seconds > 0 ? std::max(0.01, options.seconds - kLastRestS) : 0;
  std::size_t place = 0;
  switch (options.kind) {
    case ScriptKind::kExpressions:
      return write_expressions(writer, kFirstActionS, until_s);
    case ScriptKind::kRom:
      return write_range_of_motion(writer, kFirstActionS, until_s, place);
    case ScriptKind::kSpeech:
      write_speech(writer, kFirstActionS, until_s);
      break;
    case ScriptKind::kIdle:
      write_idling(writer, kFirstActionS, until_s);
      break;
    case ScriptKind::kMixed:
      write_mixed(writer, until_s);
      break;
  }
  return until_s;
}

}  // namespace

std::optional<ScriptKind> parse_script_kind(std::string_view name) {
  if (name == "expressions") return ScriptKind::kExpressions;
  if (name == "speech") return ScriptKind::kSpeech;
  if (name == "rom") return ScriptKind::kRom;
  if (name == "idle") return ScriptKind::kIdle;
  if (name == "mixed") return ScriptKind::kMixed;
  return std::nullopt;
}

PerformerScript::PerformerScript(const std::vector<std::string>& au_names, const ScriptOptions& options,
                                 const Dynamics& dynamics)
    : layer_values_(au_names.size(), 0) {
  const bool has_a_list = options.kind == ScriptKind::kExpressions || options.kind == ScriptKind::kRom;
  if (!(options.seconds > 0) && !has_a_list)
    throw std::invalid_argument("PerformerScript: only expressions and range of motion end by themselves");
  ScriptWriter writer(au_names, options, dynamics);
  const double end_s = write_face(writer, options);
  seconds_ = options.seconds > 0 ? options.seconds : end_s + 1;
  if (options.blinks)
    write_blinks(writer, seconds_ - kLastRestS, options.kind == ScriptKind::kSpeech ? kBlinksInSpeech : kBlinksAtRest);
  for (std::size_t layer = 0; layer < kScriptLayers; ++layer)
    layers_[layer] = AuMoveTrack(std::move(writer.moves[layer]), au_names.size());
  cues_ = std::move(writer.cues);
  std::stable_sort(cues_.begin(), cues_.end(),
                   [](const ScriptCue& a, const ScriptCue& b) { return a.begin_s < b.begin_s; });
  masked_.assign(writer.masked.begin(), writer.masked.end());
}

void PerformerScript::intensities_at(double time_s, std::span<double> intensities) noexcept {
  std::fill(intensities.begin(), intensities.end(), 0.0);
  for (AuMoveTrack& layer : layers_) {
    layer.values_at(time_s, layer_values_);
    for (std::size_t k = 0; k < intensities.size(); ++k) {
      const double v = std::clamp(layer_values_[k], 0.0, kHighest);
      double& x = intensities[k];
      x = x < 1 && v < 1 ? x + v * (1 - x) : std::max(x, v);
    }
  }
}

void PerformerScript::rewind() noexcept {
  for (AuMoveTrack& layer : layers_) layer.rewind();
}

}  // namespace risorius
