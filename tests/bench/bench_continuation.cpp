// How the face goes on: bench_continuation [--take FILE]... [--tune]. All continuations on alex_rom_3 (on which their
// figures were fixed) and on people never seen, clean and as solved from noisy markers; bridged drop-outs.
// With --take, tables of these takes alone, since nobody knows what a bar on them means. --tune prints what the
// baselines' figures were chosen from, and the autoregression's table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <fstream>

#include "bench/bench_report.h"
#include "bench/bridge_check.h"
#include "bench/continuation_pictures.h"
#include "bench/continuation_runs.h"
#include "generate/baselines/double_exponential.h"
#include "generate/baselines/kalman_velocity.h"
#include "generate/baselines/linear_autoregression.h"
#include "generate/continuation_models.h"
#include "replay/performer/random.h"
#include "support/test_data.h"

namespace risorius::bench {
namespace {

constexpr std::uint64_t kSeed = 11;
constexpr int kBridgeDraws = 40, kBootstraps = 1000;
const std::vector<double> kHorizons_ms{50, 100, 150, 250, 500};
constexpr ContinuationKind kDefault = ContinuationModelOptions{}.kind;

/// Mean absolute errors of one model on one take, per horizon and moving AU.
struct ModelCells {
  std::string model;
  bool is_baseline = false;
  std::vector<std::vector<double>> mae;  ///< horizons x moving AUs
  std::vector<double> coverage;          ///< per horizon
};

struct TakeResult {
  ContinuationTake take;
  std::string input;  ///< "clean" or "solved"
  std::vector<double> horizons_ms;
  std::vector<ModelCells> models;
  std::vector<Prediction> predictions;  ///< of the default
};

std::string default_name() {
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    if (entry.kind == kDefault) return std::string(entry.name);
  }
  return {};
}

bool is_baseline(ContinuationKind kind) {
  return kind == ContinuationKind::kHold || kind == ContinuationKind::kDampedVelocity ||
         kind == ContinuationKind::kDoubleExponential || kind == ContinuationKind::kKalman ||
         kind == ContinuationKind::kLinearAutoregression;
}

TakeResult run_all(ContinuationTake take, const std::string& input, std::ofstream& csv) {
  TakeResult result{std::move(take), input, {}, {}, {}};
  result.horizons_ms = native_horizons_ms(kHorizons_ms, result.take.rate_hz);
  for (const ContinuationKindEntry& entry : kContinuationKinds) {
    ContinuationRun run = run_continuation(
        result.take, make_continuation_model({.kind = entry.kind}, result.take.aus, result.take.upper_bounds),
        result.horizons_ms);
    ModelCells& cells =
        result.models.emplace_back(ModelCells{std::string(entry.name), is_baseline(entry.kind), {}, {}});
    for (std::size_t h = 0; h < result.horizons_ms.size(); ++h) {
      std::vector<double>& row = cells.mae.emplace_back();
      for (const std::size_t au : result.take.moving) {
        row.push_back(run.score.mae(h, au));
        csv << fmt::format("{},{},{},{},{:.1f},{:.6f},{},{:.4f}\n", result.take.name, input, entry.name,
                           result.take.aus[au], result.horizons_ms[h], row.back(), run.score.count(h, au),
                           run.score.coverage(h, {au}));
      }
      cells.coverage.push_back(run.score.coverage(h, result.take.moving));
    }
    if (entry.kind == kDefault && input == "clean") result.predictions = std::move(run.predictions);
  }
  return result;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Every person counts the same: the mean over takes of the mean over AUs.
double pooled_mae(const std::vector<const TakeResult*>& takes, std::size_t model, std::size_t horizon) {
  std::vector<double> by_take;
  for (const TakeResult* take : takes) by_take.push_back(mean(take->models[model].mae[horizon]));
  return mean(by_take);
}

double pooled_coverage(const std::vector<const TakeResult*>& takes, std::size_t model, std::size_t horizon) {
  std::vector<double> by_take;
  for (const TakeResult* take : takes) by_take.push_back(take->models[model].coverage[horizon]);
  return mean(by_take);
}

struct Comparison {
  std::string best_baseline;
  double ratio = 0, low = 0, high = 0;  ///< with the 95 % interval of a paired bootstrap over AUs within takes
};

Comparison compare_default(const std::vector<const TakeResult*>& takes, std::size_t horizon) {
  const auto& models = takes.front()->models;
  std::size_t best = models.size(), own = 0;
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (models[m].model == default_name()) own = m;
    const bool better = models[m].is_baseline &&
                        (best == models.size() || pooled_mae(takes, m, horizon) < pooled_mae(takes, best, horizon));
    if (better) best = m;
  }
  Comparison comparison{models[best].model, pooled_mae(takes, own, horizon) / pooled_mae(takes, best, horizon), 0, 0};
  Random random(kSeed, horizon);
  std::vector<double> ratios;
  for (int b = 0; b < kBootstraps; ++b) {
    double of_own = 0, of_best = 0;
    for (const TakeResult* take : takes) {
      const auto &own_row = take->models[own].mae[horizon], &best_row = take->models[best].mae[horizon];
      for (std::size_t i = 0; i < own_row.size(); ++i) {
        const std::size_t au = random.index(own_row.size());
        of_own += own_row[au] / static_cast<double>(own_row.size());
        of_best += best_row[au] / static_cast<double>(own_row.size());
      }
    }
    ratios.push_back(of_own / of_best);
  }
  std::sort(ratios.begin(), ratios.end());
  comparison.low = ratios[kBootstraps / 40];
  comparison.high = ratios[kBootstraps - 1 - kBootstraps / 40];
  return comparison;
}

void print_table(const std::string& title, const std::vector<const TakeResult*>& takes) {
  const auto& horizons = takes.front()->horizons_ms;
  fmt::print("\n{}: mean absolute error x 1000 (share within the 90 % interval)\n{:<24}", title, "");
  for (const double horizon : horizons) fmt::print("{:>14}", fmt::format("{:.0f} ms", horizon));
  fmt::print("\n");
  for (std::size_t m = 0; m < takes.front()->models.size(); ++m) {
    fmt::print("{:<24}", takes.front()->models[m].model);
    for (std::size_t h = 0; h < horizons.size(); ++h)
      fmt::print("{:>14}",
                 fmt::format("{:.2f} ({:.0f} %)", 1000 * pooled_mae(takes, m, h), 100 * pooled_coverage(takes, m, h)));
    fmt::print("\n");
  }
  fmt::print("{:<24}", "default / best baseline");
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const Comparison c = compare_default(takes, h);
    fmt::print("{:>14}", fmt::format("{:.3f}", c.ratio));
  }
  fmt::print("\n{:<24}", "95 % interval");
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const Comparison c = compare_default(takes, h);
    fmt::print("{:>14}", fmt::format("{:.2f} - {:.2f}", c.low, c.high));
  }
  fmt::print("\n{:<24}", "best baseline");
  for (std::size_t h = 0; h < horizons.size(); ++h)
    fmt::print("{:>14}", compare_default(takes, h).best_baseline.substr(0, 13));
  fmt::print("\n");
}

void report(const std::string& group, const std::vector<const TakeResult*>& takes, BenchReport& to) {
  for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
    const std::string at = fmt::format("{:.0f} ms", kHorizons_ms[h]);
    to.add(fmt::format("{}: default / best baseline, {}", group, at), compare_default(takes, h).ratio);
    for (std::size_t m = 0; m < takes.front()->models.size(); ++m) {
      const std::string& model = takes.front()->models[m].model;
      if (model == default_name())
        to.add(fmt::format("{}: default: 90 % interval off by, {}", group, at),
               100 * std::abs(pooled_coverage(takes, m, h) - 0.9));
      to.add(fmt::format("{}: {}, {}", group, model, at), 1000 * pooled_mae(takes, m, h));
    }
  }
}

void check_all_bridges(const std::vector<TakeResult>& results, BenchReport* to) {
  fmt::print("\nbridged drop-outs, clean takes\n{:<24}{:>8}{:>16}{:>14}{:>18}{:>14}{:>14}\n", "", "ms", "step at start",
             "step at end", "jump without", "error x 1000", "/ hold's");
  for (const double drop_out_ms : {100.0, 200.0, 300.0, 400.0, 500.0}) {
    BridgeCheck all;
    double takes = 0;
    for (const TakeResult& result : results) {
      if (result.input != "clean") continue;
      const BridgeCheck check = check_bridges(result.take, drop_out_ms, kBridgeDraws, kSeed);
      fmt::print("{:<24}{:>8.0f}{:>16.4f}{:>14.4f}{:>18.4f}{:>14.2f}{:>14.3f}\n", result.take.name, drop_out_ms,
                 check.largest_step_at_start, check.largest_step_at_end, check.mean_jump_without,
                 1000 * check.mean_error, check.mean_error / check.mean_error_of_hold);
      all.largest_step_at_start = std::max(all.largest_step_at_start, check.largest_step_at_start);
      all.largest_step_at_end = std::max(all.largest_step_at_end, check.largest_step_at_end);
      all.mean_jump_without += check.mean_jump_without;
      all.mean_error += check.mean_error;
      all.mean_error_of_hold += check.mean_error_of_hold;
      ++takes;
    }
    if (to == nullptr || takes == 0) continue;
    const std::string of = fmt::format("{:.0f} ms bridged", drop_out_ms);
    to->add(of + ": largest step within 1 ms at the start", all.largest_step_at_start);
    to->add(of + ": largest step within 1 ms at the end", all.largest_step_at_end);
    to->add(of + ": mean jump at the end without", all.mean_jump_without / takes);
    to->add(of + ": error / hold's", all.mean_error / all.mean_error_of_hold);
  }
}

std::vector<const TakeResult*> of_group(const std::vector<TakeResult>& results, const std::string& input,
                                        bool is_seen) {
  std::vector<const TakeResult*> group;
  for (const TakeResult& result : results) {
    if (result.input == input && (result.take.name == "alex_rom_3") == is_seen) group.push_back(&result);
  }
  return group;
}

HorizonPanel panel_of(const std::string& title, const std::vector<const TakeResult*>& takes) {
  HorizonPanel panel{title, takes.front()->horizons_ms, {}};
  for (std::size_t m = 0; m < takes.front()->models.size(); ++m) {
    HorizonCurve& curve = panel.curves.emplace_back(HorizonCurve{takes.front()->models[m].model, {}});
    for (std::size_t h = 0; h < panel.horizons_ms.size(); ++h) curve.mae.push_back(pooled_mae(takes, m, h));
  }
  return panel;
}

int bench(const std::vector<std::filesystem::path>& paths, bool is_standard) {
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "continuation.csv");
  csv << "take,input,model,au,horizon_ms,mae,count,coverage_of_90\n";
  std::vector<TakeResult> results;
  for (const auto& path : paths) {
    const AuRecording recording = load_au_recording(path);
    results.push_back(run_all(clean_take(recording), "clean", csv));
    fmt::print("{}: {} frames at {:g} Hz, {} of {} AUs move\n", recording.take, recording.series.frames.size(),
               recording.rate_hz, results.back().take.moving.size(), results.back().take.aus.size());
    results.push_back(run_all(solved_take(recording, kSeed), "solved", csv));
  }
  for (const TakeResult& result : results) print_table(result.take.name + ", " + result.input, {&result});
  if (!is_standard) {
    check_all_bridges(results, nullptr);
    fmt::print("written: build/bench/continuation.csv\n");
    return 0;
  }
  BenchReport to("continuation");
  std::vector<HorizonPanel> panels;
  for (const char* input : {"clean", "solved"}) {
    const auto unseen = of_group(results, input, false);
    print_table(fmt::format("{}, people never seen, all", input), unseen);
    report(fmt::format("{}, unseen", input), unseen, to);
    panels.push_back(panel_of(fmt::format("people never seen, {}", input), unseen));
  }
  check_all_bridges(results, &to);
  const TakeResult& example = *of_group(results, "clean", false).front();
  draw_continuation(panels, example.take, example.predictions, folder / "continuation.png");
  fmt::print("written: build/bench/continuation.csv, build/bench/continuation.png\n");
  return to.finish();
}

/// Mean over AUs of a model's error at every horizon, and over horizons of the ratio to hold's.
void print_tuned(const ContinuationTake& take, const std::string& what, std::unique_ptr<ContinuationModel> model) {
  const auto horizons = native_horizons_ms(kHorizons_ms, take.rate_hz);
  const ContinuationRun hold = run_continuation(
      take, make_continuation_model({.kind = ContinuationKind::kHold}, take.aus, take.upper_bounds), horizons);
  const ContinuationRun run = run_continuation(take, std::move(model), horizons);
  fmt::print("{:<44}", what);
  double sum = 0;
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const double ratio = run.score.mae(h, take.moving) / hold.score.mae(h, take.moving);
    sum += ratio / static_cast<double>(horizons.size());
    fmt::print("{:>9.3f}", ratio);
  }
  fmt::print("{:>11.4f}\n", sum);
}

int tune(const std::filesystem::path& path) {
  const AuRecording recording = load_au_recording(path);
  const ContinuationTake clean = clean_take(recording), solved = solved_take(recording, kSeed);
  for (const ContinuationTake* take : {&clean, &solved}) {
    fmt::print("\n{} ({}): error / hold's per horizon, and the mean\n", take->name,
               take == &clean ? "clean" : "solved");
    for (const double tau_ms : {5.0, 10.0, 15.0, 20.0, 30.0, 50.0, 80.0})
      print_tuned(*take, fmt::format("double_exponential, {:g} ms", tau_ms),
                  std::make_unique<DoubleExponential>(take->upper_bounds, DoubleExponentialOptions{tau_ms}));
    for (const double noise : {0.01, 0.02}) {
      for (const double acceleration : {0.01, 0.1, 1.0, 10.0, 100.0})
        print_tuned(*take, fmt::format("kalman, noise {:g}, acceleration {:g}", noise, acceleration),
                    std::make_unique<KalmanVelocity>(take->upper_bounds, KalmanVelocityOptions{noise, acceleration}));
    }
  }
  const AutoregressionTable table = fit_autoregression(motion_of(recording, 1 / AutoregressionTable::kLag_s).rows);
  fmt::print("\nautoregression table\n");
  for (const auto& row : table.weights)
    fmt::print("{{{:.4f}, {:.4f}, {:.4f}, {:.4f}}},\n", row[0], row[1], row[2], row[3]);
  return 0;
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  CLI::App app("how the face goes on");
  std::vector<std::string> chosen;
  bool is_tuning = false;
  app.add_option("--take", chosen, "Live Link Face CSV, instead of the standard ones");
  app.add_flag("--tune", is_tuning, "print what the baselines' figures were chosen from");
  CLI11_PARSE(app, argc, argv);
  std::vector<std::filesystem::path> takes(chosen.begin(), chosen.end());
  const std::filesystem::path arkit = risorius::test::data_folder() / "arkit";
  try {
    if (is_tuning) return risorius::bench::tune(takes.empty() ? arkit / "alex_rom_3.csv" : takes.front());
    if (!takes.empty()) return risorius::bench::bench(takes, false);
    for (const char* name :
         {"alex_rom_3.csv", "MySlate_161_iPhone_cal.csv", "MySlate_164_iPhone_cal.csv", "MySlate_167_iPhone_cal.csv"}) {
      if (std::filesystem::exists(arkit / name)) takes.push_back(arkit / name);
    }
    if (takes.size() < 4)
      throw std::runtime_error("the recordings are not there: set RISORIUS_DATA to the data folder");
    return risorius::bench::bench(takes, true);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_continuation: {}\n", error.what());
    return 1;
  }
}
