// From one expression to another: bench_transition [--take FILE]... All generators on real transitions (alex_rom_3,
// of which a part was trained on, and people never seen) and on the performer's six expressions.
// With --take, tables of these takes alone. Writes transition.csv (a row per transition and model), transition_aus.csv
// (per person, AU and model), transition_jumps.csv (first generated frame, as seed 003's tables) and pictures of
// courses.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <fstream>
#include <map>

#include "bench/bench_report.h"
#include "bench/transition_runs.h"
#include "generate/interpolation.h"
#include "generate/transition_models.h"
#include "replay/performer/random.h"
#include "replay/transitions/transition_picture.h"
#include "support/test_data.h"

namespace risorius::bench {
namespace {

constexpr const char* kTrainedTake = "alex_rom_3";
constexpr std::uint64_t kSeed = 11;
constexpr int kBootstraps = 1000;
constexpr float kStraight = 0.15F;  // least stray of a transition that passes through a third pose

struct ModelResult {
  std::string name;
  bool is_interpolation = false;
  std::vector<MadeTransition> made;
};

struct Group {
  std::string name;
  bool (*holds)(const TransitionCase&);
};
const std::array<Group, 5> kGroups{{
    {"real, unseen", [](const TransitionCase& c) { return c.is_real && !c.is_seen; }},
    {"real, unseen, straight",
     [](const TransitionCase& c) { return c.is_real && !c.is_seen && c.transition.stray <= kStraight; }},
    {"real, seen", [](const TransitionCase& c) { return c.is_real && c.is_seen; }},
    {"performed, unseen", [](const TransitionCase& c) { return !c.is_real && !c.is_seen; }},
    {"performed, seen", [](const TransitionCase& c) { return !c.is_real && c.is_seen; }},
}};

std::size_t count_of(const TransitionCases& cases, const Group& group) {
  return static_cast<std::size_t>(
      std::count_if(cases.cases.begin(), cases.cases.end(), [&](const TransitionCase& c) { return group.holds(c); }));
}

void print_group(const std::string& name, const std::vector<ModelResult>& results, auto holds) {
  const TransitionSummary first = summary_of(results.front().made, holds);
  if (first.count == 0) return;
  fmt::print("\n{}: {} transitions (truth's own jump {:.2f} %)\n", name, first.count, first.truth_jump_percent);
  fmt::print("{:<16}{:>10}{:>9}{:>9}{:>8}{:>8}{:>8}{:>9}{:>9}{:>8}{:>8}{:>8}{:>8}{:>9}\n", "", "MSE x1e4", "MAE x1e3",
             "NPSS", "value", "veloc.", "accel.", "jump %", "most %", "end %", "step %", "react.%", "consp.%",
             "nearest");
  for (const ModelResult& result : results) {
    const TransitionSummary s = summary_of(result.made, holds);
    fmt::print(
        "{:<16}{:>10.3f}{:>9.3f}{:>9.4f}{:>8.2f}{:>8.2f}{:>8.2f}{:>9.2f}{:>9.2f}{:>8.2f}{:>8.2f}{:>8.2f}{:>8.1f}{:>9."
        "4f}\n",
        result.name, 1e4 * s.mse, 1e3 * s.mae, s.npss, s.value_ratio, s.velocity_ratio, s.acceleration_ratio,
        s.mean_jump_percent, s.largest_jump_percent, s.end_error_percent, s.end_step_percent, s.reactivation_percent,
        s.conspicuous_percent, s.nearest_rms);
  }
}

/// 95 % interval of the ratio of mean squared errors, transitions drawn in pairs.
std::pair<double, double> interval_of_mse_ratio(const ModelResult& a, const ModelResult& b, const Group& group) {
  std::vector<std::pair<double, double>> pairs;
  for (std::size_t i = 0; i < a.made.size(); ++i) {
    if (group.holds(*a.made[i].of))
      pairs.emplace_back(a.made[i].score.mean_squared_error, b.made[i].score.mean_squared_error);
  }
  Random random(kSeed, 0);
  std::vector<double> ratios;
  for (int draw = 0; draw < kBootstraps; ++draw) {
    double of_a = 0, of_b = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto& pair = pairs[random.index(pairs.size())];
      of_a += pair.first;
      of_b += pair.second;
    }
    ratios.push_back(of_a / of_b);
  }
  std::sort(ratios.begin(), ratios.end());
  return {ratios[kBootstraps / 40], ratios[kBootstraps - 1 - kBootstraps / 40]};
}

template <class Value>
const ModelResult& best_interpolation(const std::vector<ModelResult>& results, Value value) {
  const ModelResult* best = nullptr;
  for (const ModelResult& result : results) {
    if (result.is_interpolation && (best == nullptr || value(result) < value(*best))) best = &result;
  }
  return *best;
}

void report(const std::vector<ModelResult>& results, BenchReport& to) {
  const ModelResult& own = results.front();
  for (const Group& group : {kGroups[0], kGroups[1]}) {
    const auto mse = [&](const ModelResult& r) { return summary_of(r.made, group.holds).mse; };
    const auto npss = [&](const ModelResult& r) { return summary_of(r.made, group.holds).npss; };
    const ModelResult &best_mse = best_interpolation(results, mse), &best_npss = best_interpolation(results, npss);
    to.add(group.name + ": default / best interpolation, MSE", mse(own) / mse(best_mse));
    to.add(group.name + ": default / best interpolation, NPSS", npss(own) / npss(best_npss));
    const auto [low, high] = interval_of_mse_ratio(own, best_mse, group);
    fmt::print("{}: MSE of {} / {}: {:.3f} ({:.3f} to {:.3f}); best NPSS {}\n", group.name, own.name, best_mse.name,
               mse(own) / mse(best_mse), low, high, best_npss.name);
  }
  for (const Group& group : {kGroups[0], kGroups[3]}) {
    const TransitionSummary s = summary_of(own.made, group.holds);
    to.add(group.name + ": default: start value / truth's", s.value_ratio);
    to.add(group.name + ": default: start velocity / truth's", s.velocity_ratio);
    to.add(group.name + ": default: start acceleration / truth's", s.acceleration_ratio);
    to.add(group.name + ": default: mean jump of seed 003", s.mean_jump_percent);
    to.add(group.name + ": truth: mean jump of seed 003", s.truth_jump_percent);
    to.add(group.name + ": default: reactivation", s.reactivation_percent);
  }
  const auto seen = [](const TransitionCase& c) { return c.is_seen; };
  const auto unseen = [](const TransitionCase& c) { return !c.is_seen; };
  const TransitionSummary all = summary_of(own.made, [](const TransitionCase&) { return true; });
  to.add("all: default: end error", all.end_error_percent);
  to.add("all: default: values out of bounds", all.out_of_bounds);
  to.add("unseen: default: copies of training sequences", summary_of(own.made, unseen).copies);
  to.add("unseen: default: nearest training sequence", summary_of(own.made, unseen).nearest_rms);
  to.add("seen: default: conspicuous", summary_of(own.made, seen).conspicuous_percent);
  to.add("unseen: default: conspicuous", summary_of(own.made, unseen).conspicuous_percent);
  for (const ModelResult& result : results) {
    if (!result.is_interpolation) continue;
    for (const Group& group : {kGroups[0], kGroups[3]}) {
      const TransitionSummary s = summary_of(result.made, group.holds);
      to.add(fmt::format("{}: {}, MSE", group.name, result.name), 1e4 * s.mse);
      to.add(fmt::format("{}: {}, NPSS", group.name, result.name), s.npss);
    }
  }
}

void write_tables(const std::filesystem::path& folder, const TransitionCases& cases,
                  const std::vector<ModelResult>& results) {
  std::ofstream each(folder / "transition.csv"), aus(folder / "transition_aus.csv"),
      jumps(folder / "transition_jumps.csv");
  each << "take,begin_s,from,to,variant,real,seen,frames,stray,model,mse,mae,summed_error,seam_value,"
          "seam_value_truth,mean_jump_percent,largest_jump_percent,end_error_percent,reactivation_percent,"
          "out_of_bounds,nearest_rms,conspicuous\n";
  jumps << "take,begin_s,from,to,variant,model,au,last,first,jump_percent\n";
  std::map<std::pair<std::string, std::string>, std::pair<std::vector<double>, double>> by_au;
  for (const ModelResult& result : results) {
    for (const MadeTransition& one : result.made) {
      const Transition& t = one.of->transition;
      const TransitionScore& s = one.score;
      const std::string key = fmt::format("{},{:.3f},{},{},{}", t.take, t.begin_s, t.from, t.to, t.variant);
      each << fmt::format(
          "{},{},{},{},{:.3f},{},{:.6e},{:.6e},{:.4f},{:.6f},{:.6f},{:.3f},{:.3f},{:.3f},{:.3f},{},{:.5f},{}\n", key,
          one.of->is_real ? 1 : 0, one.of->is_seen ? 1 : 0, t.course.rows(), t.stray, result.name, s.mean_squared_error,
          s.mean_absolute_error, s.conspicuousness.summed_error, s.seam.value, s.truth_seam.value, s.mean_jump_percent,
          s.largest_jump_percent, s.end_error_percent, s.reactivation_percent, s.values_out_of_bounds, one.nearest_rms,
          s.conspicuousness.is_conspicuous() ? 1 : 0);
      auto& [sums, count] = by_au[{one.of->is_real ? t.take : "performer", result.name}];
      sums.resize(cases.names.size());
      for (std::size_t au = 0; au < sums.size(); ++au) sums[au] += s.squared_error_by_au[au];
      ++count;
      const std::vector<double> first = start_jumps_percent(t.past, one.course);
      for (std::size_t au = 0; au < first.size(); ++au) {
        const auto column = static_cast<Eigen::Index>(au);
        jumps << fmt::format("{},{},{},{:.4f},{:.4f},{:.3f}\n", key, result.name, cases.names[au],
                             t.past(t.past.rows() - 1, column), one.course(0, column), first[au]);
      }
    }
  }
  aus << "take,model,au,mse\n";
  for (const auto& [key, sums] : by_au) {
    for (std::size_t au = 0; au < cases.names.size(); ++au)
      aus << fmt::format("{},{},{},{:.6e}\n", key.first, key.second, cases.names[au], sums.first[au] / sums.second);
  }
}

/// The median of each group by the default's error, so that nothing is picked by hand.
void draw_examples(const std::filesystem::path& folder, const TransitionCases& cases,
                   const std::vector<ModelResult>& results) {
  int picture = 0;
  for (const Group& group : kGroups) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < cases.cases.size(); ++i) {
      if (group.holds(cases.cases[i])) chosen.push_back(i);
    }
    if (chosen.empty()) continue;
    std::stable_sort(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
      return results.front().made[a].score.mean_squared_error < results.front().made[b].score.mean_squared_error;
    });
    const std::size_t i = chosen[chosen.size() / 2];
    const Transition& t = cases.cases[i].transition;
    std::vector<TransitionCourse> courses;
    for (const ModelResult& result : results) {
      if (result.name != "hold" && result.name != "linear")
        courses.push_back({result.name, result.made[i].course, false});
    }
    courses.insert(courses.begin(), {"truth", t.course, true});
    const std::string what = t.from.empty() ? fmt::format("{} at {:.1f} s", t.take, t.begin_s) : t.from + " to " + t.to;
    const auto path = folder / fmt::format("transition-{}.png", ++picture);
    transition_picture(group.name + ": " + what + ", the median by error", cases.names, t.past, courses, kCorpusRateHz)
        .save_png(path);
    fmt::print("written: build/bench/{}\n", path.filename().string());
  }
}

int bench(const std::vector<std::filesystem::path>& takes, bool is_standard) {
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  const StillnessOptions still;
  fmt::print(
      "still: no AU but the lids' moves faster than {:g}/s over {:.0f} ms, for {:.0f} ms at least; "
      "transitions of {} to {} frames at {:g} Hz that change some AU by {:g}\n",
      still.most_speed, 1e3 * still.window_s, 1e3 * still.least_still_s, still.least_frames, still.most_frames,
      kCorpusRateHz, still.least_change);
  const TransitionCases cases = transition_cases(takes, kTrainedTake);
  for (const Group& group : kGroups) fmt::print("{:<24} {:>4} transitions\n", group.name, count_of(cases, group));
  std::vector<ModelResult> results;
  for (const std::string_view name : kTransitionModelNames) {
    const auto model = make_transition_model(name, cases.names);
    results.push_back({std::string(name), make_interpolation(name) != nullptr, make_all(cases, *model)});
  }
  for (const Group& group : kGroups) print_group(group.name, results, group.holds);
  std::vector<std::string> people;
  for (const TransitionCase& one : cases.cases) {
    if (one.is_real && (people.empty() || people.back() != one.transition.take)) people.push_back(one.transition.take);
  }
  for (const std::string& person : people) {
    print_group(person + ", unseen", results,
                [&](const TransitionCase& c) { return c.is_real && !c.is_seen && c.transition.take == person; });
  }
  write_tables(folder, cases, results);
  draw_examples(folder, cases, results);
  fmt::print("written: build/bench/transition.csv, transition_aus.csv, transition_jumps.csv\n");
  if (!is_standard) return 0;
  BenchReport to("transition");
  report(results, to);
  return to.finish();
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  CLI::App app("from one expression to another");
  std::vector<std::string> chosen;
  app.add_option("--take", chosen, "Live Link Face CSV, instead of the standard ones");
  CLI11_PARSE(app, argc, argv);
  std::vector<std::filesystem::path> takes(chosen.begin(), chosen.end());
  const bool is_standard = takes.empty();
  const std::filesystem::path arkit = risorius::test::data_folder() / "arkit";
  try {
    if (is_standard) {
      for (const char* name : {"alex_rom_3.csv", "MySlate_161_iPhone_cal.csv", "MySlate_164_iPhone_cal.csv",
                               "MySlate_167_iPhone_cal.csv"}) {
        if (!std::filesystem::exists(arkit / name))
          throw std::runtime_error("the recordings are not there: set RISORIUS_DATA to the data folder");
        takes.push_back(arkit / name);
      }
    }
    return risorius::bench::bench(takes, is_standard);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_transition: {}\n", error.what());
    return 1;
  }
}
