#include "replay/performer/script_writer.h"

#include <algorithm>
#include <cmath>

#include "replay/takes/au_column.h"

namespace risorius {
namespace {

constexpr double kShortestMoveS = 0.04;
constexpr double kMostHurry = 0.3;      // of a way with an end that others wait for, logarithm of its duration
constexpr double kLeastChange = 0.004;  // smaller ones wait until they have added up: they cost time and show nothing
constexpr double kHighestLevel = 1;
constexpr double kOvershootChance = 0.5, kLeastOvershoot = 0.03, kMostOvershoot = 0.1, kSettleS = 0.35;
constexpr double kYield = 0.08;          // of the peak, over a held apex
constexpr double kShortestYieldS = 0.8;  // shorter apexes do not yield
constexpr int kLids = 45, kLidsClosed = 43;

}  // namespace

ScriptWriter::ScriptWriter(const std::vector<std::string>& au_names, const ScriptOptions& options,
                           const Dynamics& dynamics)
    : face(options.seed, 1),
      speech(options.seed, 2),
      blinks(options.seed, 3),
      names_(au_names),
      options_(options),
      dynamics_(dynamics) {
  for (auto& level : level_) level.assign(au_names.size(), 0);
}

std::vector<ScriptWriter::Channel> ScriptWriter::channels(std::string_view au) {
  std::vector<Channel> found;
  const AuColumn wanted = parse_au_column(au);
  for (std::size_t k = 0; k < names_.size(); ++k) {
    const AuColumn column = parse_au_column(names_[k]);
    const bool same_au = wanted.number != 0 && column.number == wanted.number &&
                         (wanted.side == ColumnSide::kNone || wanted.side == column.side);
    if (names_[k] == au || same_au) found.push_back({static_cast<std::uint32_t>(k), static_cast<char>(column.side)});
  }
  if (found.empty() && au == "AU27") return channels("AU26");
  if (found.empty()) masked.insert(std::string(au));
  return found;
}

bool ScriptWriter::has(std::string_view au) const {
  const AuColumn wanted = parse_au_column(au);
  return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
    const AuColumn column = parse_au_column(name);
    if (wanted.number == 27 && column.number == 26) return true;
    return name == au || (wanted.number != 0 && column.number == wanted.number);
  });
}

std::vector<std::string> ScriptWriter::repertoire() const {
  std::vector<std::string> list;
  for (const std::string& name : names_) {
    const AuColumn column = parse_au_column(name);
    if (column.number == kLids || column.number == kLidsClosed) continue;
    // Jaw left and right are opposites: never one action.
    const bool is_pair = column.number != 0 && column.number != 30;
    const std::string action = is_pair ? "AU" + std::to_string(column.number) : name;
    if (std::find(list.begin(), list.end(), action) == list.end()) list.push_back(action);
  }
  return list;
}

ScriptWriter::Asymmetry ScriptWriter::draw_side(Random& random) const {
  const double z = std::clamp(random.gaussian(), -2.0, 2.0), g = std::clamp(random.gaussian(), -2.0, 2.0);
  return {0.5 * dynamics_.side_lag_s * z, std::exp(0.5 * dynamics_.side_gain * g)};
}

void ScriptWriter::move(ScriptLayer layer, const AuMove& one) {
  AuMove checked = one;
  checked.duration_s = std::max(checked.duration_s, kShortestMoveS);
  if (checked.change != 0) moves[static_cast<std::size_t>(layer)].push_back(checked);
}

void ScriptWriter::cue(double begin_s, double apex_s, double end_s, std::string what) {
  cues.push_back({begin_s, apex_s, end_s, std::move(what)});
}

void ScriptWriter::act(ScriptLayer layer, std::string_view au, const Action& action) {
  Random& random = layer == ScriptLayer::kSpeech ? speech : layer == ScriptLayer::kBlink ? blinks : face;
  const Asymmetry left = draw_side(random);
  const bool overshoots = random.chance(kOvershootChance);
  const double overshoot = overshoots ? random.uniform(kLeastOvershoot, kMostOvershoot) : 0;
  for (const Channel& channel : channels(au)) {
    const double sign = channel.side == 'L' ? 1 : channel.side == 'R' ? -1 : 0;
    const double begin_s = std::max(0.0, action.begin_s + sign * left.lag_s);
    const double peak = std::min(kHighestLevel, action.peak * std::pow(left.gain, sign));
    const double apex_s = begin_s + action.onset_s, leave_s = apex_s + action.hold_s;
    // Too far and back again, and what the hold loses, must be out of the way when the face lets go.
    const double too_far = action.hold_s > kSettleS ? peak * overshoot : 0;
    const double lost = action.hold_s > kShortestYieldS ? peak * kYield : 0;
    move(layer, {channel.index, begin_s, action.onset_s, peak + too_far, dynamics_.onset_skew});
    move(layer, {channel.index, apex_s - 0.2 * action.onset_s, kSettleS, -too_far, 1});
    move(layer, {channel.index, apex_s, action.hold_s, -lost, 1});
    move(layer, {channel.index, leave_s, action.offset_s, lost - peak, dynamics_.offset_skew});
  }
}

ScriptWriter::Action ScriptWriter::draw_action(double begin_s, Random& random) const {
  return {begin_s, dynamics_.onset_s.draw(random), dynamics_.hold_s.draw(random), dynamics_.offset_s.draw(random),
          std::min(1.0, options_.amplitude * dynamics_.peak.draw(random))};
}

std::vector<double> ScriptWriter::levels_of(const AuTargets& targets, double gain, Random& random) {
  std::vector<double> levels(names_.size(), 0);
  for (const auto& [au, intensity] : targets) {
    const Asymmetry left = draw_side(random);
    for (const Channel& channel : channels(au)) {
      const double sign = channel.side == 'L' ? 1 : channel.side == 'R' ? -1 : 0;
      levels[channel.index] = std::min(kHighestLevel, gain * intensity * std::pow(left.gain, sign));
    }
  }
  return levels;
}

ScriptWriter::SideGain ScriptWriter::draw_side_gain(Random& random) const {
  const double gain = draw_side(random).gain;
  return {gain, 1 / gain};
}

std::vector<double> ScriptWriter::draw_shifts(double begin_s, double until_s, Random& random) const {
  std::vector<double> times;
  if (dynamics_.timing.shifts_per_second <= 0) return times;
  // One has mostly been made before the next begins: two opposite ones at once would shoot over both levels.
  const double mean_s = 1 / dynamics_.timing.shifts_per_second;
  const double pause_s = std::min(dynamics_.onset_s.median, 0.7 * mean_s);
  for (double time_s = begin_s; (time_s += pause_s + random.exponential(mean_s - pause_s)) < until_s;)
    times.push_back(time_s);
  return times;
}

void ScriptWriter::pose_to(ScriptLayer layer, const std::vector<double>& levels, const std::vector<bool>& leads,
                           double begin_s, double duration_s, Random& random) {
  const Timing& timing = dynamics_.timing;
  auto& now = level_[static_cast<std::size_t>(layer)];
  int last_number = -1;
  double lag_s = 0, pace = 1;
  bool splits = false;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const int number = parse_au_column(names_[k]).number;
    // Sides of one AU go together but for their lag; muscles of one posture do not.
    if (number == 0 || number != last_number) {
      lag_s = timing.lag_s * std::clamp(random.gaussian(), -2.0, 2.0);
      pace = std::exp(timing.pace * std::clamp(random.gaussian(), -2.0, 2.0));
      splits = random.chance(timing.split_probability);
    }
    last_number = number;
    const double side_lag_s = 0.5 * dynamics_.side_lag_s * std::clamp(random.gaussian(), -2.0, 2.0);
    const double change = levels[k] - now[k];
    if (std::abs(change) < kLeastChange) continue;
    now[k] = levels[k];
    const auto au = static_cast<std::uint32_t>(k);
    const double start_s = std::max(0.0, begin_s + (leads[k] ? 0 : lag_s) + side_lag_s);
    const double way_s = std::max(kShortestMoveS, leads[k] ? duration_s : pace * duration_s);
    const double skew = change > 0 ? dynamics_.onset_skew : dynamics_.offset_skew;
    const double first = splits ? timing.split_share : 1;
    move(layer, {au, start_s, way_s, first * change, skew});
    if (splits) move(layer, {au, start_s + timing.split_gap * way_s, way_s, (1 - first) * change, skew});
  }
}

void ScriptWriter::go_to(ScriptLayer layer, const std::vector<double>& levels, double begin_s, double duration_s,
                         double jitter_s, Random& random) {
  auto& now = level_[static_cast<std::size_t>(layer)];
  int last_number = -1;
  double start_s = begin_s, pace = 1;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const double change = levels[k] - now[k];
    const int number = parse_au_column(names_[k]).number;
    // Sides of one AU start together but for their lag; muscles of one expression do not.
    if (number == 0 || number != last_number) {
      start_s = begin_s + jitter_s * random.uniform();
      pace = std::exp(std::clamp(dynamics_.timing.pace * random.gaussian(), -kMostHurry, kMostHurry));
    }
    last_number = number;
    now[k] = levels[k];
    if (std::abs(change) < 1e-9) continue;
    const double lag_s = 0.5 * dynamics_.side_lag_s * std::clamp(random.gaussian(), -2.0, 2.0);
    const double skew = change > 0 ? dynamics_.onset_skew : dynamics_.offset_skew;
    move(layer, {static_cast<std::uint32_t>(k), std::max(0.0, start_s + lag_s), duration_s * pace, change, skew});
  }
}

}  // namespace risorius
