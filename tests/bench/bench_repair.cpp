// Accuracy of gap filling and despiking on a real take: bench_repair [FOLDER of jaw.csv and eyebrows.csv] [draws].
// Protocol after Gloersen & Federolf 2016: 0.1 mm white noise, two gaps of equal length in K markers after frame 300,
// Euclidean error against the take before the noise. The same draws for every method.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "bench/bench_report.h"
#include "capture/repair/despiker.h"
#include "capture/repair/gap_baselines.h"
#include "capture/repair/gap_filler.h"
#include "capture/repair/offline_repair.h"
#include "support/marker_csv.h"
#include "support/marker_defects.h"
#include "support/test_data.h"

namespace risorius {
namespace {

struct Task {
  std::size_t gap, markers;
};
constexpr Task kTasks[] = {{6, 4}, {30, 4}, {60, 4}, {120, 4}, {30, 12}, {120, 12}};
constexpr std::size_t kFirstGapFrame = 300;
constexpr float kNoiseMm = 0.1F;

struct Sums {
  double error = 0, squared = 0, inside = 0, count = 0, step = 0, steps = 0;
};

double distance(Position a, Position b) {
  return std::hypot(double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z});
}

std::vector<MarkerFrame> with_noise(const std::vector<MarkerFrame>& clean, std::mt19937_64& random) {
  std::normal_distribution<float> noise(0, kNoiseMm);
  std::vector<MarkerFrame> frames = clean;
  for (MarkerFrame& frame : frames) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      frame.position_mm[i].x += noise(random);
      frame.position_mm[i].y += noise(random);
      frame.position_mm[i].z += noise(random);
    }
  }
  return frames;
}

void cut_gaps(std::vector<MarkerFrame>& frames, Task task, std::mt19937_64& random) {
  std::vector<std::size_t> markers(frames.front().count);
  for (std::size_t i = 0; i < markers.size(); ++i) markers[i] = i;
  std::shuffle(markers.begin(), markers.end(), random);
  const std::size_t half = (frames.size() - kFirstGapFrame) / 2;
  for (std::size_t k = 0; k < task.markers; ++k) {
    for (std::size_t part = 0; part < 2; ++part) {
      const std::size_t begin = kFirstGapFrame + part * half + random() % (half - task.gap - 1);
      for (std::size_t f = begin; f < begin + task.gap; ++f) {
        frames[f].state[markers[k]] = MarkerState::kMissing;
        frames[f].position_mm[markers[k]] = {};
      }
    }
  }
}

using Fill = std::function<void(std::vector<MarkerFrame>&, const MarkerSet&)>;

void fill_causal(std::vector<MarkerFrame>& frames, const MarkerSet& set, FillMethod method) {
  GapFillerOptions options;
  options.method = method;
  options.max_gap_ns = 10'000'000'000;
  GapFiller filler(options);
  filler.use_marker_set(set);
  for (MarkerFrame& frame : frames) {
    filler.push(frame);
    filler.pop(frame);
  }
}

void score(const std::vector<MarkerFrame>& clean, const std::vector<MarkerFrame>& cut,
           const std::vector<MarkerFrame>& filled, Sums& sums) {
  constexpr double kTwoSided90 = 1.6449;
  for (std::size_t f = 1; f < clean.size(); ++f) {
    for (std::size_t i = 0; i < clean[f].count; ++i) {
      if (cut[f].state[i] != MarkerState::kMissing) continue;
      const Position a = filled[f].position_mm[i], b = clean[f].position_mm[i];
      const double error = distance(a, b);
      sums.error += error;
      sums.squared += error * error;
      const double bound = kTwoSided90 * double{filled[f].standard_deviation_mm[i]};
      sums.inside += (std::abs(a.x - b.x) <= bound) + (std::abs(a.y - b.y) <= bound) + (std::abs(a.z - b.z) <= bound);
      sums.count += 1;
      if (cut[f - 1].state[i] != MarkerState::kMissing) {
        const double moved = distance(clean[f].position_mm[i], clean[f - 1].position_mm[i]);
        sums.step += std::max(0.0, distance(a, filled[f - 1].position_mm[i]) - moved);
        sums.steps += 1;
      }
    }
  }
}

void bench_fill(const test::MarkerTake& take, int draws, bench::BenchReport& report) {
  const std::vector<std::pair<const char*, Fill>> methods = {
      {"linear (seed 000)", [](auto& frames, const auto&) { fill_linear(frames, INT64_MAX); }},
      {"hold", [](auto& frames, const auto& set) { fill_causal(frames, set, FillMethod::kHold); }},
      {"damped velocity", [](auto& frames, const auto& set) { fill_causal(frames, set, FillMethod::kDampedVelocity); }},
      {"low-rank, causal", [](auto& frames, const auto& set) { fill_causal(frames, set, FillMethod::kLowRank); }},
      {"low-rank, offline", [](auto& frames, const auto& set) { fill_offline(frames, set, {}); }},
  };
  std::printf("%-18s", "gap x markers");
  for (const Task& task : kTasks) std::printf("  %15zux%-7zu", task.gap, task.markers);
  std::printf("\n(mean / RMSE mm, share inside the 90 %% interval, step at gap start mm)\n");
  for (const auto& [name, method] : methods) {
    std::printf("%-18s", name);
    for (const Task& task : kTasks) {
      Sums sums;
      for (int draw = 0; draw < draws; ++draw) {
        std::mt19937_64 random(static_cast<std::uint64_t>(draw) + 1);
        auto cut = with_noise(take.frames, random);
        cut_gaps(cut, task, random);
        auto filled = cut;
        method(filled, take.set);
        score(take.frames, cut, filled, sums);
      }
      std::printf("  %5.3f/%5.3f %3.0f%% %4.2f", sums.error / sums.count, std::sqrt(sums.squared / sums.count),
                  100 * sums.inside / (3 * sums.count), sums.step / sums.steps);
      report.add(std::string(name) + ", " + std::to_string(task.gap) + "x" + std::to_string(task.markers),
                 sums.error / sums.count);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

void bench_despike(const char* name, const test::MarkerTake& take, DespikeMethod method, int seeds,
                   bench::BenchReport& report) {
  test::DespikeScore score;
  double seconds = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const test::Defects defects = test::make_defects(take, static_cast<std::uint64_t>(seed));
    DespikerOptions options;
    options.method = method;
    Despiker despiker(options);
    despiker.use_marker_set(take.set);
    auto judged = defects.frames;
    const auto start = std::chrono::steady_clock::now();
    for (MarkerFrame& frame : judged) {
      despiker.push(frame);
      despiker.pop(frame);
    }
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    score.add(defects, judged);
  }
  std::printf("%-22s events %zu, found %.2f %%, samples found %.2f %%, false alarms %.3f %%, %.1f us per frame\n", name,
              score.events, 100.0 * static_cast<double>(score.found) / static_cast<double>(score.events),
              100.0 * static_cast<double>(score.rejected_false) / static_cast<double>(score.false_samples),
              100.0 * static_cast<double>(score.rejected_good) / static_cast<double>(score.good_samples),
              1e6 * seconds / static_cast<double>(take.frames.size()) / seeds);
  report.add(std::string("despike ") + name + ": events found",
             100.0 * static_cast<double>(score.found) / static_cast<double>(score.events));
  report.add(std::string("despike ") + name + ": false alarms",
             100.0 * static_cast<double>(score.rejected_good) / static_cast<double>(score.good_samples));
}

}  // namespace
}  // namespace risorius

int main(int argc, char** argv) {
  using namespace risorius;
  const std::filesystem::path folder = argc > 1 ? argv[1] : (test::data_folder() / "animface").string();
  const int draws = argc > 2 ? std::max(1, std::atoi(argv[2])) : 20;
  const test::MarkerTake jaw = test::read_marker_csv(folder / "jaw.csv", 60);
  if (jaw.frames.empty()) {
    std::fprintf(stderr, "%s: no takes there (give the folder of jaw.csv)\n", folder.c_str());
    return 1;
  }
  const test::MarkerTake eyebrows = test::read_marker_csv(folder / "eyebrows.csv", 60);
  bench::BenchReport report("repair");
  bench_despike("jaw", jaw, DespikeMethod::kHeadFrame, draws, report);
  bench_despike("jaw (seed 000)", jaw, DespikeMethod::kDisplacement, draws, report);
  bench_despike("eyebrows", eyebrows, DespikeMethod::kHeadFrame, draws, report);
  bench_despike("eyebrows (seed 000)", eyebrows, DespikeMethod::kDisplacement, draws, report);
  bench_fill(jaw, draws, report);
  return report.finish();
}
