// Range of motion as laboratories record it, and idling: single actions, one side alone, combinations, each once or a
// few times, with the rests, holds and co-activations of the dynamics table.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "replay/performer/posture_fit.h"
#include "replay/performer/script_writer.h"
#include "replay/takes/au_column.h"

namespace risorius {
namespace {

using Task = std::vector<std::string>;  // AUs that act together

// Combinations that FACS teaches because they look unlike the sum of their parts.
const std::vector<Task> kCombinations{
    {"AU1", "AU2"},   {"AU1", "AU4"},   {"AU1", "AU2", "AU4"}, {"AU1", "AU2", "AU5"},    {"AU4", "AU5"},
    {"AU6", "AU12"},  {"AU6", "AU15"},  {"AU9", "AU17"},       {"AU10", "AU17"},         {"AU10", "AU12"},
    {"AU12", "AU15"}, {"AU12", "AU17"}, {"AU12", "AU27"},      {"AU15", "AU17"},         {"AU17", "AU24"},
    {"AU18", "AU27"}, {"AU20", "AU27"}, {"AU22", "AU27"},      {"AU10", "AU16", "AU27"}, {"AU4", "AU7", "AU9"}};

/// Each AU alone; one side alone; then the combinations that the channels allow.
std::vector<Task> tasks_of(const ScriptWriter& writer) {
  std::vector<Task> tasks;
  for (const std::string& au : writer.repertoire()) tasks.push_back({au});
  for (const std::string& name : writer.names()) {
    const AuColumn column = parse_au_column(name);
    if (column.side != ColumnSide::kNone && column.number != 30 && column.number != 45 && column.number != 43)
      tasks.push_back({name});
  }
  for (const Task& task : kCombinations) {
    if (std::all_of(task.begin(), task.end(), [&](const std::string& au) { return writer.has(au); }))
      tasks.push_back(task);
  }
  return tasks;
}

constexpr std::size_t kTop = 11;                     // PostureTable's quantile 0.99
constexpr double kActing = 0.1;                      // an AU whose top is below has not been asked for
constexpr double kLeastReach = 0.5, kMostReach = 2;  // one recording does not say that an AU cannot
constexpr double kLastWayS = 1.2;                    // kept free for the way back to neutral

/// A face that goes from posture to posture. What a task asks for leads; the other AUs come along as the postures of
/// the dynamics table say, shift while they are held, and stay where they are until the next posture moves them.
class PostureWalk {
 public:
  explicit PostureWalk(ScriptWriter& writer)
      : writer_(writer), sampler_(writer.dynamics().postures), peaks_(writer.names().size(), 0) {
    for (const std::string& name : writer.names()) in_table_.push_back(sampler_.find(base_of_column(name)));
    const PostureTable& table = writer.dynamics().postures;
    double sum = 0, seen = 0;
    for (std::size_t au = 0; au < table.aus.size(); ++au) {
      if (table.levels[au][kTop] < kActing) continue;
      sum += std::log(table.levels[au][kTop]);
      seen += 1;
    }
    usual_top_ = seen > 0 ? std::exp(sum / seen) : 1;
  }

  /// Takes the task's AUs up to about `peak`, and shifts until `until_s`.
  void hold(const Task& task, double peak, double begin_s, double way_s, double until_s) {
    Random& random = writer_.face;
    std::fill(peaks_.begin(), peaks_.end(), 0.0);
    leads_.clear();
    is_other_side_.assign(writer_.names().size(), false);
    for (const std::string& au : task) {
      const ScriptWriter::SideGain side = writer_.draw_side_gain(random);
      const auto found = sampler_.find(base_of_column(au));
      const double of_au = peak * (found ? reach_of(*found) : 1);
      for (const ScriptWriter::Channel& channel : writer_.channels(au))
        peaks_[channel.index] = std::min(1.0, writer_.options().amplitude * of_au * side.of(channel));
      if (found) leads_.push_back({*found, sampler_.share_of(*found, of_au)});
      if (parse_au_column(au).side == ColumnSide::kNone) continue;
      for (std::size_t k = 0; k < in_table_.size(); ++k)
        if (found && in_table_[k] == found) is_other_side_[k] = true;
    }
    go(writer_.dynamics().timing.persistence, begin_s, way_s, until_s);
  }
  /// Lets the last task's AUs go, and shifts until `until_s`.
  void let_go(double begin_s, double way_s, double until_s) {
    std::fill(peaks_.begin(), peaks_.end(), 0.0);
    is_other_side_.assign(writer_.names().size(), false);
    for (PostureSampler::Lead& lead : leads_) lead.share = writer_.face.uniform(0, 0.5);
    go(writer_.dynamics().timing.persistence, begin_s, way_s, until_s);
  }
  void end(double begin_s, double way_s) {
    const std::size_t count = writer_.names().size();
    writer_.pose_to(ScriptLayer::kFace, std::vector<double>(count, 0.0), std::vector<bool>(count, true), begin_s, way_s,
                    writer_.face);
  }

 private:
  void go(double kept, double begin_s, double way_s, double until_s) {
    const Timing& timing = writer_.dynamics().timing;
    Random& random = writer_.face;
    sampler_.renew(kept, random);
    sampler_.lead(leads_);
    pose(0, begin_s, way_s);
    const std::vector<PostureSampler::Lead> led = leads_;
    for (const double shift_s : writer_.draw_shifts(begin_s + way_s, until_s, random)) {
      sampler_.renew(std::sqrt(1 - timing.shift_renewal * timing.shift_renewal), random);
      sampler_.lead(led);
      pose(timing.apex_shift, shift_s, writer_.dynamics().onset_s.draw(random));
    }
  }
  /// Brings the sampler's posture to the channels; what leads has its own level.
  void pose(double apex_shift, double begin_s, double way_s) {
    const std::size_t count = writer_.names().size();
    std::vector<double> levels(count, 0.0);
    std::vector<bool> leads(count, false);
    const double gain = writer_.options().amplitude * writer_.dynamics().follower_gain;
    for (std::size_t k = 0; k < count; ++k) {
      const double shift = std::exp(apex_shift * std::clamp(writer_.face.gaussian(), -2.0, 2.0));
      leads[k] = peaks_[k] > 0;
      if (leads[k]) {
        levels[k] = std::min(1.0, peaks_[k] * shift);
      } else if (writer_.options().co_activation && in_table_[k] && !is_other_side_[k]) {
        levels[k] = std::min(1.0, gain * sampler_.level(*in_table_[k]));
      }
    }
    writer_.pose_to(ScriptLayer::kFace, levels, leads, begin_s, way_s, writer_.face);
  }

  /// How far an AU goes where it leads, against the others: by what it was seen to do at its strongest.
  double reach_of(std::size_t au) const {
    return std::clamp(writer_.dynamics().postures.levels[au][kTop] / usual_top_, kLeastReach, kMostReach);
  }
  ScriptWriter& writer_;
  PostureSampler sampler_;
  std::vector<bool> is_other_side_;  ///< per channel, of an AU that one side was asked of
  double usual_top_ = 1;
  std::vector<std::optional<std::size_t>> in_table_;  ///< per channel
  std::vector<double> peaks_;                         ///< per channel; 0 where it does not lead
  std::vector<PostureSampler::Lead> leads_;
};

}  // namespace

double write_range_of_motion(ScriptWriter& writer, double begin_s, double until_s, std::size_t& place) {
  std::vector<Task> tasks = tasks_of(writer);
  Random& random = writer.face;
  // A list that is cut short would show brows alone: then its order is drawn, one-sided actions last.
  if (until_s > 0 && writer.options().kind == ScriptKind::kRom) {
    for (std::size_t i = tasks.size(); i > 1; --i) std::swap(tasks[i - 1], tasks[random.index(i)]);
    std::stable_partition(tasks.begin(), tasks.end(),
                          [](const Task& task) { return parse_au_column(task.front()).side == ColumnSide::kNone; });
  }
  const Dynamics& dynamics = writer.dynamics();
  PostureWalk walk(writer);
  double time_s = begin_s;
  bool repeats = false;
  for (std::size_t done = 0; !tasks.empty() && (until_s > 0 || done < tasks.size());) {
    const double way_s = dynamics.onset_s.draw(random), hold_s = dynamics.hold_s.draw(random);
    const double peak = std::min(1.0, dynamics.peak.draw(random));
    const double apex_s = time_s + way_s, leave_s = apex_s + hold_s;
    const double release_s = dynamics.offset_s.draw(random), next_s = leave_s + dynamics.rest_s.draw(random);
    if (until_s > 0 && leave_s + kLastWayS > until_s) break;
    if (!repeats) ++place;
    const Task& task = tasks[(place - 1) % tasks.size()];
    repeats = random.chance(dynamics.repeat_probability);
    if (!repeats) ++done;
    walk.hold(task, peak, time_s, way_s, leave_s);
    writer.cue(time_s, apex_s, leave_s, fmt::format("{}", fmt::join(task, "+")));
    // The next action may begin while the last one still fades: rests are counted from its letting go.
    walk.let_go(leave_s, release_s, until_s > 0 ? std::min(next_s, until_s - kLastWayS) : next_s);
    time_s = next_s;
  }
  const double end_s = until_s > 0 ? std::min(time_s, until_s - kLastWayS) : time_s;
  walk.end(end_s, 0.5 * kLastWayS);
  return end_s + kLastWayS;
}

double write_idling(ScriptWriter& writer, double begin_s, double until_s) {
  // Small things that a resting face does: brows, a hint of a smile, lips pressed, a swallow.
  const std::vector<Task> tasks{{"AU1", "AU2"}, {"AU12"}, {"AU24"}, {"AU17", "AU24"}, {"AU4"}, {"AU14"}};
  Random& random = writer.face;
  double time_s = begin_s + random.uniform(0.5, 4);
  while (true) {
    ScriptWriter::Action action = writer.draw_action(time_s, random);
    action.peak = random.uniform(0.04, 0.2);
    action.hold_s = std::min(action.hold_s, 1.5);
    if (action.end_s() > until_s) return until_s;
    const Task& task = tasks[random.index(tasks.size())];
    for (const std::string& au : task) {
      if (writer.has(au)) writer.act(ScriptLayer::kFace, au, action);
    }
    time_s = action.end_s() + random.exponential(5);
  }
}

}  // namespace risorius
