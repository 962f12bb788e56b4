// What the synthetic performer plays: moves of AUs over time, written from a seed for the channels that a rig has.
// Three layers play at once: the face (expressions, range of motion), speech, and blinks; they add up softly,
// x + v (1 - x), so that a blink during a squint still ends at 1. The pace of everything but speech and blinks is drawn
// from a Dynamics table.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/performer/au_moves.h"
#include "replay/performer/dynamics.h"

namespace risorius {

/// kMixed: passages of all of them in turn, expressions first.
enum class ScriptKind { kExpressions, kSpeech, kRom, kIdle, kMixed };
/// "expressions", "speech", "rom", "idle" or "mixed".
std::optional<ScriptKind> parse_script_kind(std::string_view name);

enum class ScriptLayer : std::uint8_t { kFace, kSpeech, kBlink };
inline constexpr std::size_t kScriptLayers = 3;

struct ScriptOptions {
  ScriptKind kind = ScriptKind::kMixed;
  double seconds = 60;  ///< 0: until the list of expressions or of the range of motion has been played once
  std::uint64_t seed = 1;
  bool co_activation = true;  ///< in range of motion, AUs bring others with them as people's do
  bool blinks = true;
  double amplitude = 1;  ///< of range of motion, times the dynamics' peaks (cut off at 1), 0.1 to 4
};

/// What is played when, for people and for cutting transitions out: "happy > sad", "AU12", "AU1+AU2", "phrase".
struct ScriptCue {
  double begin_s = 0;  ///< onset
  double apex_s = 0;   ///< where it is reached and held
  double end_s = 0;    ///< where it is left
  std::string what;
};

class PerformerScript {
 public:
  /// An action's AU without side ("AU12") moves AU12, or AU12L and AU12R, whichever of the names there are.
  PerformerScript(const std::vector<std::string>& au_names, const ScriptOptions& options,
                  const Dynamics& dynamics = shipped_dynamics());

  /// Sets all intensities, 0 to 1.15. Times must not decrease until rewind().
  void intensities_at(double time_s, std::span<double> intensities) noexcept;
  void rewind() noexcept;

  double seconds() const noexcept { return seconds_; }
  const std::vector<AuMove>& moves(ScriptLayer layer) const noexcept {
    return layers_[static_cast<std::size_t>(layer)].moves();
  }
  /// Sorted by begin.
  const std::vector<ScriptCue>& cues() const noexcept { return cues_; }
  /// AUs that the script asked for and the names do not hold; sorted.
  const std::vector<std::string>& masked() const noexcept { return masked_; }

 private:
  std::array<AuMoveTrack, kScriptLayers> layers_;
  std::vector<double> layer_values_;
  double seconds_ = 0;
  std::vector<ScriptCue> cues_;
  std::vector<std::string> masked_;
};

}  // namespace risorius
