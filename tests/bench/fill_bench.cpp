#include "bench/fill_bench.h"

#include <atomic>
#include <fmt/core.h>
#include <fmt/os.h>
#include <thread>

#include "capture/check.h"
#include "capture/repair/fill_methods.h"
#include "capture/repair/gap_filler.h"
#include "capture/repair/offline_repair.h"

namespace risorius::bench {
namespace {

constexpr std::int64_t kNoLimitNs = INT64_MAX / 2;

/// `work(n)` for n below `count`, on all cores; what each does is its own.
template <class Work>
void in_parallel(int count, Work work) {
  std::atomic<int> next = 0;
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < std::max(1U, std::thread::hardware_concurrency()); ++t) {
    threads.emplace_back([&] {
      for (int n = next++; n < count; n = next++) work(n);
    });
  }
}

void fill_causally(std::vector<MarkerFrame>& frames, const MarkerSet& set,
                   const std::shared_ptr<const KnownMotion>& known) {
  GapFiller filler({.max_gap_ns = kNoLimitNs, .known_motion = known});
  filler.use_marker_set(set);
  for (MarkerFrame& frame : frames) {
    RISORIUS_CHECK(filler.push(frame));
    filler.pop(frame);
  }
}

}  // namespace

std::vector<Filler> fillers(const std::shared_ptr<const KnownMotion>& known) {
  std::vector<Filler> all;
  for (const FillMethodEntry& method : fill_methods()) {
    all.push_back(
        {std::string(method.name), method.is_causal, method.states_deviation, all.size() >= 2, false,
         [&method](std::vector<MarkerFrame>& frames, const MarkerSet& set) { method.fill(frames, set, kNoLimitNs); }});
  }
  if (!known) return all;
  all.push_back(
      {"offline + rig", false, true, false, true, [known](std::vector<MarkerFrame>& frames, const MarkerSet& set) {
         fill_offline(frames, set, {.max_gap_ns = kNoLimitNs, .known_motion = known});
       }});
  all.push_back(
      {"causal + rig", true, true, false, true,
       [known](std::vector<MarkerFrame>& frames, const MarkerSet& set) { fill_causally(frames, set, known); }});
  return all;
}

std::size_t TaskScores::best_baseline(const std::vector<Filler>& methods, bool causal_only) const {
  std::size_t best = methods.size();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (!methods[m].is_baseline) continue;
    if (causal_only && !methods[m].is_causal) continue;
    if (best == methods.size() || mean_mm(by_method[m]) < mean_mm(by_method[best])) best = m;
  }
  return best;
}

std::vector<TaskScores> score_fills(const test::MarkerTake& clean, const std::vector<GapTask>& tasks,
                                    const std::vector<Filler>& methods, int draws) {
  std::vector<TaskScores> scores;
  for (const GapTask& task : tasks) {
    if (const std::string problem = problem_with(clean, task); !problem.empty()) {
      fmt::print("{}: left out: {}\n", task.name, problem);
      continue;
    }
    TaskScores& of_task = scores.emplace_back(TaskScores{task, {}});
    of_task.by_method.assign(methods.size(), MethodScore(static_cast<std::size_t>(draws)));
    std::atomic<int> done = 0;
    in_parallel(draws, [&](int draw) {
      const std::vector<MarkerFrame> cut = draw_gaps(clean, task, static_cast<std::uint64_t>(draw));
      for (std::size_t m = 0; m < methods.size(); ++m) {
        std::vector<MarkerFrame> filled = cut;
        methods[m].fill(filled, clean.set);
        of_task.by_method[m][static_cast<std::size_t>(draw)] =
            score_draw(clean.frames, cut, filled, methods[m].is_causal);
      }
      fmt::print(stderr, "\r{:<16} {} of {} draws ", task.name, ++done, draws);
    });
  }
  fmt::print(stderr, "\r{:40}\r", "");
  return scores;
}

void print_fill_table(const std::vector<TaskScores>& scores, const std::vector<Filler>& methods) {
  fmt::print("\nmean / RMSE, mm\n{:<16}", "");
  for (const TaskScores& of_task : scores) fmt::print(" {:>13}", of_task.task.name);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    fmt::print("\n{:<16}", methods[m].name);
    for (const TaskScores& of_task : scores) {
      fmt::print("   {:5.3f}/{:5.3f}", mean_mm(of_task.by_method[m]), rmse_mm(of_task.by_method[m]));
    }
  }
  fmt::print("\n\nof the 90 % interval: share inside, %; CRPS / CRPS with the deviation of the other draws, mm\n");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    fmt::print("{:<16}", methods[m].name);
    for (const TaskScores& of_task : scores) {
      const MethodScore& score = of_task.by_method[m];
      fmt::print(" {:3.0f} {:4.2f}/{:4.2f}", methods[m].states_deviation ? coverage_percent(score) : 0,
                 methods[m].states_deviation ? crps_mm(score, false) : 0, crps_mm(score, true));
    }
    fmt::print("\n");
  }
  fmt::print("\nstep at the start / end of a gap that the motion does not explain, 99th percentile, mm\n");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    fmt::print("{:<16}", methods[m].name);
    for (const TaskScores& of_task : scores) {
      fmt::print("   {:5.2f}/{:5.2f}", start_step_p99_mm(of_task.by_method[m]), end_step_p99_mm(of_task.by_method[m]));
    }
    fmt::print("\n");
  }
}

void write_fill_csv(const std::string& path, const std::vector<TaskScores>& scores,
                    const std::vector<Filler>& methods) {
  auto file = fmt::output_file(path);
  file.print(
      "task,method,mean_mm,rmse_mm,inside_90_percent,crps_stated_mm,crps_calibrated_mm,start_step_p99_mm,end_step_p99_"
      "mm\n");
  for (const TaskScores& of_task : scores) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const MethodScore& s = of_task.by_method[m];
      const bool stated = methods[m].states_deviation;
      file.print("{},{},{:.4f},{:.4f},{},{},{:.4f},{:.4f},{:.4f}\n", of_task.task.name, methods[m].name, mean_mm(s),
                 rmse_mm(s), stated ? fmt::format("{:.2f}", coverage_percent(s)) : "",
                 stated ? fmt::format("{:.4f}", crps_mm(s, false)) : "", crps_mm(s, true), start_step_p99_mm(s),
                 end_step_p99_mm(s));
    }
  }
}

}  // namespace risorius::bench
