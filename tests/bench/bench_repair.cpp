// Accuracy of repair: gaps filled and false tracks found. bench_repair [--draws N] [--take FILE]...
// By default the two real takes and one of the performer, judged by tests/bench/bars.tsv. With --take, any take: tables
// alone, since nobody knows what a bar on it means.
#include <CLI/CLI.hpp>
#include <chrono>
#include <fmt/core.h>

#include "bench/bench_report.h"
#include "bench/despike_bench.h"
#include "bench/fill_bench.h"
#include "bench/real_defects.h"
#include "capture/check.h"
#include "capture/repair/despiker.h"
#include "capture/repair/gap_filler.h"
#include "replay/commands/take_arguments.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/rig_fit.h"
#include "solve/rigs/rig_motion.h"
#include "support/synthetic_take.h"
#include "support/test_data.h"

namespace risorius::bench {
namespace {

constexpr double kNoise3dMm = kNoiseMm * 1.7320508;
constexpr int kDefectSeeds = 6;

struct BenchTake {
  std::string name;
  test::MarkerTake clean;
  bool is_main = false;                             ///< all tasks, all rows
  std::shared_ptr<const KnownMotion> known_motion;  ///< of a rig fitted to its neutral, or null
};

test::MarkerTake read_all(TakeReader& reader) {
  test::MarkerTake take{reader.info().markers, {}};
  for (MarkerFrame frame; reader.next(frame);) take.frames.push_back(frame);
  return take;
}

/// Somebody who is not the built-in face, whole and without noise; the head moves fast.
BenchTake performed() {
  PerformerOptions options{.seed = 11, .rate_hz = 60, .seconds = 30, .noise_mm = 0, .occlusion_share = 0};
  options.false_track_share = 0;
  options.head_motion = 3;
  options.perturb = PerturbOptions::like_people();
  PerformerTake take(builtin_rig(), options);
  const Rig& actor = take.performance().true_rig();
  const Rig fitted =
      fit_rig(builtin_face(), actor.marker_names, actor.neutral_mm, find_landmark_map(kBuiltinLayout)).rig;
  return {"performed", read_all(take), false, motion_of(fitted)};
}

double least_crps(const TaskScores& scores, const std::vector<Filler>& all, bool causal_only) {
  double least = 1e30;
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (!all[m].is_baseline) continue;
    if (!causal_only || all[m].is_causal) least = std::min(least, crps_mm(scores.by_method[m], true));
  }
  return least;
}

/// A default, with or without a rig, against the best of the methods that may stand against it.
void report_default(const BenchTake& take, const TaskScores& scores, const std::vector<Filler>& all, std::size_t m,
                    BenchReport* report) {
  const bool is_causal = all[m].is_causal;
  const MethodScore& own = scores.by_method[m];
  const std::size_t best = scores.best_baseline(all, is_causal);
  const MethodScore& other = scores.by_method[best];
  const Interval interval = ratio_interval(own, other);
  const double ratio = mean_mm(own) / mean_mm(other), of_rmse = rmse_mm(own) / rmse_mm(other);
  fmt::print("{:<10} {:<14} {:<13} {:.3f} / {:<16} {:.3f} = {:.2f} ({:.2f} to {:.2f}), RMSE {:.2f}\n", take.name,
             scores.task.name, all[m].name, mean_mm(own), all[best].name, mean_mm(other), ratio, interval.low,
             interval.high, of_rmse);
  if (report == nullptr) return;
  const auto row = [&](const char* what) {
    return fmt::format("{}: {}{}, {}", take.name, all[m].name, what, scores.task.name);
  };
  report->add(row(is_causal ? " / best causal" : " / best"), ratio);
  report->add(row(": 90 % interval off by"), std::abs(coverage_percent(own) - 90));
  if (!take.is_main || all[m].knows_the_face) return;
  report->add(row(is_causal ? " / best causal RMSE" : " / best RMSE"), of_rmse);
  report->add(row(": CRPS / best"), crps_mm(own, false) / least_crps(scores, all, is_causal));
  report->add(row(": step at the start / noise"), start_step_p99_mm(own) / kNoise3dMm);
  report->add(row(": step at the end / noise"), end_step_p99_mm(own) / kNoise3dMm);
}

void bench_fill(const BenchTake& take, int draws, BenchReport* report) {
  const std::vector<Filler> all = fillers(take.known_motion);
  std::vector<GapTask> tasks = gap_tasks(take.clean.set.rate_hz);
  const std::vector<TaskScores> scores = score_fills(take.clean, tasks, all, draws);
  fmt::print("\n== {}: {} frames, {} markers, {} draws\n", take.name, take.clean.frames.size(),
             take.clean.set.names.size(), draws);
  print_fill_table(scores, all);
  fmt::print("\ndefault / best of the others, mean error (95 % of the paired bootstrap)\n");
  for (const TaskScores& of_task : scores) {
    for (std::size_t m = 0; m < all.size(); ++m) {
      if (!all[m].is_baseline) report_default(take, of_task, all, m, report);
    }
    if (report == nullptr || !take.is_main) continue;
    for (std::size_t m = 0; m < all.size(); ++m) {
      report->add(fmt::format("{}: {}, {}", take.name, all[m].name, of_task.task.name), mean_mm(of_task.by_method[m]));
    }
    const auto pca = static_cast<std::size_t>(std::ranges::find(all, "pca", &Filler::name) - all.begin());
    report->add(fmt::format("{}: causal / pca offline, {}", take.name, of_task.task.name),
                mean_mm(of_task.by_method[1]) / mean_mm(of_task.by_method[pca]));
  }
  write_fill_csv(fmt::format("{}/build/bench/repair_{}.csv", RISORIUS_SOURCE_DIR, take.name), scores, all);
}

void print_despike(const std::string& name, const DespikeResult& result) {
  fmt::print("{:<36} {:5} events, found {:6.2f} % (samples {:6.2f} %), false alarms {:.3f} %\n", name,
             result.score.events, result.found_percent(), result.samples_percent(), result.false_alarm_percent());
}

void report_despike(const std::string& name, const DespikeResult& result, BenchReport* report) {
  print_despike(name, result);
  if (report == nullptr) return;
  report->add("despike " + name + ": events found", result.found_percent());
  report->add("despike " + name + ": false alarms", result.false_alarm_percent());
}

void bench_despike(const BenchTake& take, BenchReport* report) {
  DespikeResult by_program, by_test, plain;
  for (std::uint64_t seed = 1; seed <= kDefectSeeds; ++seed) {
    const SpoiltTake spoilt = spoil_by_program(take.clean, seed);
    add_judged(spoilt, DespikeMethod::kHeadFrame, by_program);
    add_judged(spoilt, DespikeMethod::kDisplacement, plain);
    add_judged(spoil_by_test(take.clean, seed), DespikeMethod::kHeadFrame, by_test);
  }
  report_despike(take.name + ", risorius defects", by_program, report);
  report_despike(take.name + ", test defects", by_test, report);
  report_despike(take.name + ", risorius defects (seed 000)", plain, report);
  const auto folder = test::data_folder() / "animface";
  if (!std::filesystem::exists(folder / (take.name + "_defects.c3d"))) return;
  DespikeResult given;
  add_judged(read_spoilt(folder, take.name, take.clean), DespikeMethod::kHeadFrame, given);
  report_despike(take.name + "_defects.c3d", given, report);
}

/// As a newcomer has it: the built-in face fitted to a neutral, here of the frames [20, last).
std::shared_ptr<const KnownMotion> motion_of_fitted(const test::MarkerTake& take, std::size_t last) {
  Eigen::Matrix3Xd neutral = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(take.set.names.size()));
  for (std::size_t f = 20; f < last; ++f) {
    for (std::size_t i = 0; i < take.set.names.size(); ++i) {
      const Position& p = take.frames[f].position_mm[i];
      neutral.col(static_cast<Eigen::Index>(i)) += Eigen::Vector3d(p.x, p.y, p.z) / static_cast<double>(last - 20);
    }
  }
  return motion_of(fit_rig(builtin_face(), take.set.names, neutral, find_landmark_map("animface41")).rig);
}

/// Despike and fill as the live service does them, on one core, every tenth marker now and then hidden.
void bench_throughput(BenchReport& report) {
  constexpr int kPasses = 5;
  test::MarkerTake take = test::synthetic_take({.markers = 60, .frames = 6000, .rate_hz = 240, .head_moves = true});
  for (std::size_t i = 0; i < 60; i += 10) {
    for (std::size_t f = 20 * i; f < take.frames.size(); f += 900) test::hide(take, i, f, 120);
  }
  double best_s = 1e30;
  MarkerFrame frame;
  for (int pass = 0; pass < kPasses; ++pass) {
    Despiker despiker;
    GapFiller filler;
    despiker.use_marker_set(take.set);
    filler.use_marker_set(take.set);
    const auto begin = std::chrono::steady_clock::now();
    for (const MarkerFrame& measured : take.frames) {
      RISORIUS_CHECK(despiker.push(measured) && despiker.pop(frame));
      RISORIUS_CHECK(filler.push(frame, despiker) && filler.pop(frame));
      despiker.settle();
      filler.settle();
    }
    best_s = std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  const double frames_per_s = static_cast<double>(take.frames.size()) / best_s;
  report.add("despike + fill, 60 markers, one core", frames_per_s);
  report.add("despike + fill, 60 markers, of 240 Hz", frames_per_s / take.set.rate_hz);
}

std::vector<BenchTake> default_takes() {
  std::vector<BenchTake> takes;
  const auto folder = test::data_folder() / "animface";
  for (const auto& [name, last_neutral] : {std::pair{"jaw", 90}, std::pair{"eyebrows", 120}}) {
    takes.push_back({name, test::read_marker_csv(folder / (std::string(name) + ".csv"), 60), takes.empty(), {}});
    if (takes.back().clean.frames.empty()) {
      throw std::runtime_error(folder.string() + ": no takes there; set RISORIUS_DATA, or give --take FILE");
    }
    takes.back().known_motion = motion_of_fitted(takes.back().clean, last_neutral);
  }
  takes.push_back(performed());
  return takes;
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  using namespace risorius;
  CLI::App app("bench repair: gaps and false tracks");
  std::vector<std::string> files;
  int draws = 20;
  TakeArguments arguments;
  app.add_option("--take", files, kTakeNames);
  app.add_option("--draws", draws, "of the main take; a third of them of the others")->check(CLI::Range(1, 1000));
  arguments.add_to(app);
  CLI11_PARSE(app, argc, argv);
  try {
    if (files.empty()) {
      bench::BenchReport report("repair");
      for (const bench::BenchTake& take : bench::default_takes()) {
        bench::bench_fill(take, take.is_main ? draws : std::max(1, draws / 3), &report);
        bench::bench_despike(take, &report);
      }
      bench::bench_real_defects(test::data_folder(), report);
      bench::bench_throughput(report);
      return report.finish();
    }
    for (const std::string& file : files) {
      const auto reader = open_take_or_builtin(file, arguments.options());
      print_warnings(*reader);
      const bench::BenchTake take{path_of_take(file).stem().string(), bench::read_all(*reader), true, {}};
      bench::bench_fill(take, draws, nullptr);
      bench::bench_despike(take, nullptr);
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench repair: {}\n", error.what());
    return 1;
  }
}
