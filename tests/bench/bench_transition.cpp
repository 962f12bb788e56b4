// From one expression to another: bench_transition [--take FILE]... [--seed-weights FILE]... [--tables DIR]. All
// generators on real transitions (alex_rom_3, of which a part was trained on, and people never seen) and on the
// performer's six expressions; those of seed 003 where weights of `./run train seed` are given. With --take, tables of
// these takes alone. Writes what transition_files.h says, and pictures of courses.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <set>

#include "bench/bench_report.h"
#include "bench/transition_files.h"
#include "bench/transition_runs.h"
#include "capture/errors.h"
#include "generate/interpolation.h"
#include "generate/seed_generator.h"
#include "generate/transition_models.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/performer/action_statistics.h"
#include "replay/performer/random.h"
#include "replay/transitions/transition_picture.h"
#include "support/test_data.h"

namespace risorius::bench {
namespace {

constexpr const char* kTrainedTake = "alex_rom_3";
constexpr std::uint64_t kSeed = 11;
constexpr int kBootstraps = 1000;
constexpr float kStraight = 0.15F;  // least stray of a transition that passes through a third pose

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
  std::size_t width = 0;
  for (const ModelResult& result : results) width = std::max(width, result.name.size());
  fmt::print("{:<{}}{:>10}{:>9}{:>9}{:>8}{:>8}{:>8}{:>9}{:>9}{:>8}{:>8}{:>8}{:>8}{:>9}\n", "", width, "MSE x1e4",
             "MAE x1e3", "NPSS", "value", "veloc.", "accel.", "jump %", "most %", "end %", "step %", "react.%",
             "consp.%", "nearest");
  for (const ModelResult& result : results) {
    const TransitionSummary s = summary_of(result.made, holds);
    fmt::print(
        "{:<{}}{:>10.3f}{:>9.3f}{:>9.4f}{:>8.2f}{:>8.2f}{:>8.2f}{:>9.2f}{:>9.2f}{:>8.2f}{:>8.2f}{:>8.2f}{:>8.1f}{:>9."
        "4f}\n",
        result.name, width, 1e4 * s.mse, 1e3 * s.mae, s.npss, s.value_ratio, s.velocity_ratio, s.acceleration_ratio,
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

double frames_of(const TransitionCase& one) { return static_cast<double>(one.transition.course.rows()); }

/// How far `expected` is off the true durations, as a factor: the median over a group.
template <class Expected>
double duration_factor(const TransitionCases& cases, const Group& group, Expected expected) {
  std::vector<double> off;
  for (const TransitionCase& one : cases.cases) {
    if (group.holds(one)) off.push_back(std::abs(std::log(expected(one) / frames_of(one))));
  }
  return std::exp(quantile_of(off, 0.5));
}

/// Beside one duration for all: the median of those that were trained on.
void report_durations(const TransitionCases& cases, TransitionModel& model, BenchReport& to) {
  std::vector<double> known;
  for (const TransitionCase& one : cases.cases)
    if (one.is_seen) known.push_back(frames_of(one));
  const double usual = quantile_of(known, 0.5);
  for (const Group& group : {kGroups[0], kGroups[3]}) {
    to.add(group.name + ": default: duration off by", duration_factor(cases, group, [&](const TransitionCase& one) {
             return static_cast<double>(
                 model.expected_frames({.past = one.transition.past,
                                        .target = one.transition.course.row(one.transition.course.rows() - 1),
                                        .rate_hz = kCorpusRateHz}));
           }));
    to.add(group.name + ": one duration for all: off by",
           duration_factor(cases, group, [&](const TransitionCase&) { return usual; }));
  }
}

/// Of transitions that begin while the face moves, as live targets do.
void report_under_way(const std::vector<ModelResult>& results, BenchReport& to) {
  const ModelResult& own = results.front();
  for (const Group& group : {kGroups[0], kGroups[3]}) {
    const auto mse = [&](const ModelResult& r) { return summary_of(r.made, group.holds).mse; };
    const TransitionSummary s = summary_of(own.made, group.holds);
    to.add(group.name + ", under way: default / best interpolation, MSE",
           s.mse / mse(best_interpolation(results, mse)));
    to.add(group.name + ", under way: default: start value / truth's", s.value_ratio);
    to.add(group.name + ", under way: default: start velocity / truth's", s.velocity_ratio);
    to.add(group.name + ", under way: default: start acceleration / truth's", s.acceleration_ratio);
  }
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
      // Of seed 003's models the plain one: a picture of all cures and studies shows none.
      const bool is_shown = result.name != "hold" && result.name != "linear" && !result.name.starts_with("seed_");
      if (is_shown) courses.push_back({result.name, result.made[i].course, false});
    }
    courses.insert(courses.begin(), {"truth", t.course, true});
    const std::string what = t.from.empty() ? fmt::format("{} at {:.1f} s", t.take, t.begin_s) : t.from + " to " + t.to;
    const auto path = folder / fmt::format("transition-{}.png", ++picture);
    transition_picture(group.name + ": " + what + ", the median by error", cases.names, t.past, courses, kCorpusRateHz)
        .save_png(path);
    fmt::print("written: build/bench/{}\n", path.filename().string());
  }
}

struct Arguments {
  std::vector<std::filesystem::path> takes, seed_weights;
  std::filesystem::path tables;
  bool is_standard = false;
};

using Models = std::vector<std::unique_ptr<TransitionModel>>;

/// The default first. Throws UserError for weights that are no seed's.
Models make_models(const Arguments& arguments, const std::vector<std::string>& au_names) {
  Models models;
  for (const std::string_view name : kTransitionModelNames) models.push_back(make_transition_model(name, au_names));
  std::set<std::string, std::less<>> names;
  for (const std::filesystem::path& path : arguments.seed_weights) {
    const Safetensors weights = load_safetensors(path);
    for (const SeedCure cure : {SeedCure::kNone, SeedCure::kReinterpolated}) {
      models.push_back(std::make_unique<SeedGenerator>(weights, path.string(), au_names, cure));
      if (!names.emplace(models.back()->name()).second)
        throw UserError(path.string(), fmt::format("is a model '{}', as a file before it", models.back()->name()),
                        "give each model once");
    }
  }
  return models;
}

std::vector<ModelResult> make_results(const Models& models, const TransitionCases& cases) {
  std::vector<ModelResult> results;
  for (const auto& model : models) {
    const std::string name(model->name());
    results.push_back({name, make_interpolation(name) != nullptr, make_all(cases, *model)});
  }
  return results;
}

int bench(const Arguments& arguments) {
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  const StillnessOptions still;
  fmt::print(
      "still: no AU but the lids' moves faster than {:g}/s over {:.0f} ms, for {:.0f} ms at least; "
      "transitions of {} to {} frames at {:g} Hz that change some AU by {:g}\n",
      still.most_speed, 1e3 * still.window_s, 1e3 * still.least_still_s, still.least_frames, still.most_frames,
      kCorpusRateHz, still.least_change);
  const Models models = make_models(arguments, corpus_aus());
  const TransitionCases cases = transition_cases(arguments.takes, kTrainedTake);
  for (const Group& group : kGroups) fmt::print("{:<24} {:>4} transitions\n", group.name, count_of(cases, group));
  const std::vector<ModelResult> results = make_results(models, cases);
  for (const Group& group : kGroups) print_group(group.name, results, group.holds);
  std::vector<std::string> people;
  for (const TransitionCase& one : cases.cases) {
    if (one.is_real && (people.empty() || people.back() != one.transition.take)) people.push_back(one.transition.take);
  }
  for (const std::string& person : people) {
    print_group(person + ", unseen", results,
                [&](const TransitionCase& c) { return c.is_real && !c.is_seen && c.transition.take == person; });
  }
  write_transition_csv(folder, cases, results);
  draw_examples(folder, cases, results);
  fmt::print("written: build/bench/transition.csv, transition_aus.csv, transition_jumps.csv\n");
  write_seed003_tables(arguments.tables, cases, results);
  fmt::print("written: {}: seed 003's tables\n", arguments.tables.string());
  const TransitionCases begun = begun_under_way(cases);
  const std::vector<ModelResult> results_under_way = make_results(models, begun);
  for (const Group& group : kGroups) print_group(group.name + ", under way", results_under_way, group.holds);
  if (!arguments.is_standard) return 0;
  BenchReport to("transition");
  report(results, to);
  report_under_way(results_under_way, to);
  report_durations(cases, *models.front(), to);
  return to.finish();
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  CLI::App app("from one expression to another");
  risorius::bench::Arguments arguments;
  arguments.tables = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench/transition-tables";
  app.add_option("--take", arguments.takes, "Live Link Face CSV, instead of the standard ones");
  app.add_option("--seed-weights", arguments.seed_weights, "safetensors of `./run train seed`, a model more each");
  app.add_option("--tables", arguments.tables, "folder for seed 003's tables, CSV and PNG");
  CLI11_PARSE(app, argc, argv);
  arguments.is_standard = arguments.takes.empty();
  const std::filesystem::path arkit = risorius::test::data_folder() / "arkit";
  try {
    if (arguments.is_standard) {
      for (const char* name : {"alex_rom_3.csv", "MySlate_161_iPhone_cal.csv", "MySlate_164_iPhone_cal.csv",
                               "MySlate_167_iPhone_cal.csv"}) {
        if (!std::filesystem::exists(arkit / name))
          throw std::runtime_error("the recordings are not there: set RISORIUS_DATA to the data folder");
        arguments.takes.push_back(arkit / name);
      }
    }
    return risorius::bench::bench(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_transition: {}\n", error.what());
    return 1;
  }
}
