// Writes the moves of a performer's script: finds the channels of an AU, gives each side its own lag and strength, and
// puts actions together out of onset, overshoot, slowly yielding apex and offset. The passages (expressions, range of
// motion, speech, idling, blinks) are functions of their own files over this class.
#pragma once

#include <array>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "replay/performer/expression_table.h"
#include "replay/performer/performer_script.h"

namespace risorius {

class ScriptWriter {
 public:
  ScriptWriter(const std::vector<std::string>& au_names, const ScriptOptions& options, const Dynamics& dynamics);

  struct Channel {
    std::uint32_t index;
    char side;  ///< 'L', 'R' or 0
  };
  /// Channels of "AU12" (one, or left and right) or "AU12L"; empty and noted as masked if there is none. AU27 is
  /// served by AU26 where there is no other jaw.
  std::vector<Channel> channels(std::string_view au);
  bool has(std::string_view au) const;

  /// One action: up to `peak`, held, and back to nothing, on all channels of the AU.
  struct Action {
    double begin_s = 0, onset_s = 0, hold_s = 0, offset_s = 0, peak = 0;
    double end_s() const noexcept { return begin_s + onset_s + hold_s + offset_s; }
  };
  void act(ScriptLayer layer, std::string_view au, const Action& action);
  /// An action with times and peak drawn from the dynamics.
  Action draw_action(double begin_s, Random& random) const;
  /// How much more a channel of this side moves than the other, as a factor; 1 where there are no sides.
  struct SideGain {
    double left = 1, right = 1;
    double of(const Channel& channel) const noexcept {
      return channel.side == 'L' ? left : channel.side == 'R' ? right : 1;
    }
  };
  SideGain draw_side_gain(Random& random) const;

  /// Takes a layer's channels to these levels (one per channel) as a face changes its posture: each AU sets out,
  /// hurries and breaks its way by the dynamics' timing. `leads` (one per channel) set out at `begin_s` itself.
  void pose_to(ScriptLayer layer, const std::vector<double>& levels, const std::vector<bool>& leads, double begin_s,
               double duration_s, Random& random);
  /// Times of shifts while a posture is held.
  std::vector<double> draw_shifts(double begin_s, double until_s, Random& random) const;

  /// Takes a layer's channels from where they are to these levels (one per channel), in about `duration_s`.
  void go_to(ScriptLayer layer, const std::vector<double>& levels, double begin_s, double duration_s, double jitter_s,
             Random& random);
  /// Levels of targets by AU, with asymmetry; one per channel.
  std::vector<double> levels_of(const AuTargets& targets, double gain, Random& random);

  void move(ScriptLayer layer, const AuMove& move);
  void cue(double begin_s, double apex_s, double end_s, std::string what);

  const std::vector<std::string>& names() const noexcept { return names_; }
  const ScriptOptions& options() const noexcept { return options_; }
  const Dynamics& dynamics() const noexcept { return dynamics_; }
  /// Numbers of AUs and other names that can act, without sides, in order: "AU1", "AU12", ..., "mouthLeft". No lids.
  std::vector<std::string> repertoire() const;

  Random face, speech, blinks;  ///< streams of their own, so that layers do not disturb each other

  std::array<std::vector<AuMove>, kScriptLayers> moves;
  std::vector<ScriptCue> cues;
  std::set<std::string> masked;

 private:
  /// A side's lag and gain for this action.
  struct Asymmetry {
    double lag_s = 0, gain = 1;
  };
  Asymmetry draw_side(Random& random) const;

  const std::vector<std::string>& names_;
  const ScriptOptions& options_;
  const Dynamics& dynamics_;
  std::array<std::vector<double>, kScriptLayers> level_;  ///< where go_to has brought each channel
};

/// Passages begin and end with a neutral face. They return when they are over, at or before `until_s` (or, for the
/// first two, when their list has been played once, if `until_s` is 0).
double write_expressions(ScriptWriter& writer, double begin_s, double until_s);
/// `place` is where in the list to begin; it is moved on.
double write_range_of_motion(ScriptWriter& writer, double begin_s, double until_s, std::size_t& place);
double write_speech(ScriptWriter& writer, double begin_s, double until_s);
double write_idling(ScriptWriter& writer, double begin_s, double until_s);
void write_blinks(ScriptWriter& writer, double until_s, double per_minute);

}  // namespace risorius
