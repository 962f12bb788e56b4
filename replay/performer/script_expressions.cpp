// Expressions: all directed pairs of each set, as one walk that takes every pair once (an Eulerian circuit of the
// complete graph, Hierholzer 1873), in an order drawn from the seed. Apexes are held; the face goes from one expression
// straight to the next.
#include <algorithm>
#include <cmath>

#include "replay/performer/script_writer.h"

namespace risorius {
namespace {

constexpr const char* kNeutral = "neutral";
constexpr double kLeastHoldS = 0.5, kMostHoldS = 4;

/// Every directed pair of `names` once: names.size() * (names.size() - 1) + 1 places, the first and last equal.
std::vector<std::string> walk_all_pairs(std::vector<std::string> names, Random& random) {
  const std::size_t count = names.size();
  std::vector<std::vector<std::size_t>> ways(count);
  for (std::size_t from = 0; from < count; ++from) {
    for (std::size_t to = 0; to < count; ++to) {
      if (to != from) ways[from].push_back(to);
    }
    for (std::size_t i = ways[from].size(); i > 1; --i) std::swap(ways[from][i - 1], ways[from][random.index(i)]);
  }
  std::vector<std::size_t> open{0}, walk;
  while (!open.empty()) {
    auto& left = ways[open.back()];
    if (left.empty()) {
      walk.push_back(open.back());
      open.pop_back();
    } else {
      const std::size_t next = left.back();
      left.pop_back();
      open.push_back(next);
    }
  }
  std::vector<std::string> places;
  for (auto place = walk.rbegin(); place != walk.rend(); ++place) places.push_back(names[*place]);
  return places;
}

/// One of the variants of which the rig has most.
const AuTargets& choose_variant(ScriptWriter& writer, const std::vector<AuTargets>& variants) {
  std::vector<const AuTargets*> best;
  double most = -1;
  for (const AuTargets& variant : variants) {
    double present = 0, all = 0;
    for (const auto& [au, intensity] : variant) {
      all += intensity;
      if (writer.has(au)) present += intensity;
    }
    const double share = all > 0 ? present / all : 1;
    if (share > most + 1e-9) best.clear();
    if (share >= most - 1e-9) best.push_back(&variant);
    most = std::max(most, share);
  }
  return *best[writer.face.index(best.size())];
}

class Walk {
 public:
  Walk(ScriptWriter& writer, double begin_s, double until_s)
      : writer_(writer), time_s_(begin_s), until_s_(until_s), jitter_s_(2 * writer.dynamics().timing.lag_s) {}

  void take_set(const std::string& set) {
    std::vector<std::string> names = shipped_expression_table().sets.find(set)->second;
    // Beginning with neutral, if the set has it, spares a way that is not in the list.
    std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == kNeutral; });
    for (const std::string& place : walk_all_pairs(std::move(names), writer_.face)) {
      if (is_over()) return;
      if (place != at_) go(place);
    }
  }
  /// Back to neutral; when the face is there.
  double end() {
    if (at_ != kNeutral) go(kNeutral);
    return time_s_;
  }
  bool is_over() const { return until_s_ > 0 && time_s_ >= until_s_ - 2 * kLongestWayS; }

 private:
  static constexpr double kLongestWayS = 2;

  void go(const std::string& to) {
    Random& random = writer_.face;
    const Dynamics& dynamics = writer_.dynamics();
    const double way_s =
        std::min(kLongestWayS, 1.4 * (to == kNeutral ? dynamics.offset_s : dynamics.onset_s).draw(random));
    double hold_s = std::clamp(dynamics.hold_s.draw(random), kLeastHoldS, kMostHoldS);
    const double gain = random.uniform(0.6, 1);
    const AuTargets& variant = choose_variant(writer_, shipped_expression_table().expressions.find(to)->second);
    const std::vector<double> levels = writer_.levels_of(variant, gain, random);
    const double apex_s = time_s_ + way_s + jitter_s_;
    // There must be time left for the way back.
    if (until_s_ > 0) hold_s = std::clamp(until_s_ - kLongestWayS - apex_s, 0.0, hold_s);
    // Too far, and back to the level that is held.
    if (random.chance(0.5) && !variant.empty()) {
      std::vector<double> beyond = levels;
      const double overshoot = 1 + random.uniform(0.03, 0.1);
      for (double& level : beyond) level = std::min(1.0, level * overshoot);
      writer_.go_to(ScriptLayer::kFace, beyond, time_s_, way_s, jitter_s_, random);
      writer_.go_to(ScriptLayer::kFace, levels, apex_s - 0.15 * way_s, 0.35, 0, random);
    } else {
      writer_.go_to(ScriptLayer::kFace, levels, time_s_, way_s, jitter_s_, random);
    }
    shift_apex(levels, apex_s, apex_s + hold_s);
    writer_.cue(time_s_, apex_s, apex_s + hold_s, at_ + " > " + to);
    time_s_ = apex_s + hold_s;
    at_ = to;
  }

  /// A held expression is never quite still: its levels shift about where they were reached.
  void shift_apex(const std::vector<double>& levels, double begin_s, double until_s) {
    Random& random = writer_.face;
    const Dynamics& dynamics = writer_.dynamics();
    constexpr double kSettledS = 0.3;
    const std::vector<bool> nobody(levels.size(), false);
    for (const double shift_s : writer_.draw_shifts(begin_s + kSettledS, until_s - dynamics.onset_s.median, random)) {
      std::vector<double> shifted = levels;
      for (double& level : shifted)
        level = std::min(1.0, level * std::exp(dynamics.timing.apex_shift * std::clamp(random.gaussian(), -2.0, 2.0)));
      writer_.pose_to(ScriptLayer::kFace, shifted, nobody, shift_s, dynamics.onset_s.draw(random), random);
    }
  }

  ScriptWriter& writer_;
  double time_s_, until_s_;
  double jitter_s_;  ///< muscles of one expression do not start together
  std::string at_ = kNeutral;
};

}  // namespace

double write_expressions(ScriptWriter& writer, double begin_s, double until_s) {
  Walk walk(writer, begin_s, until_s);
  do {
    walk.take_set("seed003");
    walk.take_set("seed001");
  } while (until_s > 0 && !walk.is_over());
  return walk.end();
}

}  // namespace risorius
