// Range of motion as laboratories record it, and idling: single actions, one side alone, combinations, each once or a
// few times, with the rests, holds and co-activations of the dynamics table.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

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

/// What comes along with an AU, in its own time: it begins a little later and ends a little earlier.
void co_activate(ScriptWriter& writer, const std::string& au, const Task& task, const ScriptWriter::Action& action) {
  Random& random = writer.face;
  const auto list = writer.dynamics().co_actions.find(au);
  if (list == writer.dynamics().co_actions.end()) return;
  for (const CoAction& other : list->second) {
    // Drawn before it is known whether it can act, so that a rig's channels do not change the timing of the others.
    const bool acts = random.chance(other.probability);
    const double strength = other.ratio * std::exp(0.3 * random.gaussian());
    const double late = random.uniform(0, 0.3), early = random.uniform(0, 0.3);
    const bool is_asked = std::find(task.begin(), task.end(), other.au) != task.end();
    if (!acts || is_asked || !writer.has(other.au)) continue;
    ScriptWriter::Action along = action;
    along.peak = std::min(1.0, action.peak * strength);
    along.begin_s += late * action.onset_s;
    along.hold_s = std::max(0.05, action.hold_s * (1 - early) - late * action.onset_s);
    writer.act(ScriptLayer::kFace, other.au, along);
  }
}

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
  double time_s = begin_s;
  bool repeats = false;
  for (std::size_t done = 0; !tasks.empty() && (until_s > 0 || done < tasks.size());) {
    const ScriptWriter::Action action = writer.draw_action(time_s, random);
    if (until_s > 0 && action.end_s() > until_s) break;
    if (!repeats) ++place;
    const Task& task = tasks[(place - 1) % tasks.size()];
    repeats = random.chance(writer.dynamics().repeat_probability);
    if (!repeats) ++done;
    for (const std::string& au : task) {
      ScriptWriter::Action one = action;
      one.begin_s += random.uniform(0, 0.05);
      writer.act(ScriptLayer::kFace, au, one);
      if (writer.options().co_activation) co_activate(writer, au, task, one);
    }
    const double leave_s = time_s + action.onset_s + action.hold_s;
    writer.cue(time_s, time_s + action.onset_s, leave_s, fmt::format("{}", fmt::join(task, "+")));
    // The next action may begin while the last one still fades: rests are counted from its letting go.
    time_s = leave_s + writer.dynamics().rest_s.draw(random);
  }
  return time_s;
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
