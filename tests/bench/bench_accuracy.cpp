// How true the solve is (EVALUATION section 2): against exact truth of a performer on four rigs, whose face is the
// solver's or another person's, causal and joint beside a per-frame ridge solve of the same frames; what outliers cost;
// on real takes, AUs that must be absent and markers left out. Writes build/bench/accuracy-*.png.
// bench_accuracy [--seconds S] [--au CSV --au-rate HZ] [--take FILE --rig RIG]; with --take only that take is looked
// at.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>

#include "bench/accuracy_pictures.h"
#include "bench/au_accuracy.h"
#include "bench/bench_report.h"
#include "bench/ict_archive.h"
#include "bench/real_take_checks.h"
#include "bench/solve_case.h"
#include "bench/solved_series.h"
#include "capture/errors.h"
#include "replay/performer/random.h"
#include "replay/takes/au_csv.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/ict_face.h"
#include "solve/joint/take_solver.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using bench::AuAccuracy;
using bench::solve_frame_by_frame;
using bench::SolveCase;
using bench::Solved;
using bench::table_of;

constexpr double kNoiseMm = 0.2, kOutlierShare = 0.02, kPoint = 20;

struct Arguments {
  double seconds = 8, au_rate_hz = 60;
  std::string au, take, rig;
};

/// Per frame, least squares with a ridge and nothing else; in the same pose as ours, found by the same joint steps.
AuSolverOptions plain_ridge() {
  AuSolverOptions options;
  options.temporal = options.l1 = 0;
  options.robust_iterations = 0;
  return options;
}

/// The worst over the rigs of what each says about one kind of truth.
struct Worst {
  double causal = 0, causal_p90 = 0, joint = 0, joint_p90 = 0, causal_lag = 0, joint_lag = 0, outliers = 0, kkt = 0;
  double least_correlation = 1;
  double outliers_sum = 0;  // over rigs
  double causal_moving = 0, joint_moving = 0, crosstalk = 0;
};

void raise(double& worst, double value) { worst = std::max(worst, value); }

void measure_case(const SolveCase& with, SolveCase spoiled, const SolveCase& alone, Worst& worst) {
  const auto aus = static_cast<Eigen::Index>(with.rig.au_count());
  const std::vector<bench::AuTie> ties = bench::identifiable_aus(with.rig, kNoiseMm);
  const Eigen::MatrixXd truth = bench::tied_series(with.truth, ties);
  const auto accuracy = [&](const Solved& solved) {
    return bench::accuracy_of(truth, bench::tied_series(solved.x, ties));
  };
  const Solved ridge = table_of(solve_frame_by_frame(with.rig, with.markers, with.frames, plain_ridge()), aus);
  const Solved causal = table_of(solve_frame_by_frame(with.rig, with.markers, with.frames, {}), aus);
  const Solved joint = table_of(TakeSolver(with.rig, {}).solve(with.markers, with.frames), aus);
  bench::add_outliers(spoiled, kOutlierShare, 3);
  const Solved with_outliers = table_of(solve_frame_by_frame(spoiled.rig, spoiled.markers, spoiled.frames, {}), aus);
  const std::vector<bench::MethodAccuracy> methods{{"ridge per frame", accuracy(ridge)},
                                                   {"causal", accuracy(causal)},
                                                   {"joint", accuracy(joint)},
                                                   {"causal, 2 % outliers", accuracy(with_outliers)}};
  fmt::print("{}: {} frames, {} identifiable AUs of {}\n", with.name, with.frames.size(), ties.size(), aus);
  for (const auto& [name, a] : methods) {
    fmt::print("  {:22} RMSE median {:.4f}, p90 {:.4f}, of AUs that move {:.4f}; correlation {:.3f}; lag {:5.2f} ms\n",
               name, a.rmse_median, a.rmse_p90, a.moving_rmse_median, a.correlation_median,
               a.lag_median_frames * 1000 / with.rate_hz);
  }
  std::fflush(stdout);
  const AuAccuracy &r = methods[0].accuracy, &c = methods[1].accuracy, &j = methods[2].accuracy,
                   &o = methods[3].accuracy;
  raise(worst.causal, c.rmse_median / r.rmse_median);
  raise(worst.causal_moving, c.moving_rmse_median / r.moving_rmse_median);
  raise(worst.joint_moving, j.moving_rmse_median / r.moving_rmse_median);
  raise(worst.causal_p90, c.rmse_p90 / r.rmse_p90);
  raise(worst.joint, j.rmse_median / r.rmse_median);
  raise(worst.joint_p90, j.rmse_p90 / r.rmse_p90);
  raise(worst.causal_lag, std::abs(c.lag_median_frames));
  raise(worst.joint_lag, std::abs(j.lag_median_frames));
  raise(worst.outliers, o.rmse_median / c.rmse_median);
  worst.outliers_sum += o.rmse_median / c.rmse_median;
  raise(worst.kkt, std::max({causal.largest_kkt, joint.largest_kkt, with_outliers.largest_kkt}));
  worst.least_correlation = std::min(worst.least_correlation, c.correlation_median);
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  std::string file = with.name;
  std::replace(file.begin(), file.end(), ' ', '-');
  const Solved of_alone = table_of(solve_frame_by_frame(alone.rig, alone.markers, alone.frames), aus);
  const Eigen::MatrixXd crosstalk =
      bench::accuracy_of(bench::tied_series(alone.truth, ties), bench::tied_series(of_alone.x, ties)).crosstalk;
  const double own = crosstalk.diagonal().mean();
  const double others =
      std::sqrt((crosstalk.squaredNorm() - crosstalk.diagonal().squaredNorm()) / static_cast<double>(crosstalk.rows()));
  fmt::print(
      "  one AU after the other, causal: {:.2f} of it found on average; all others together {:.2f} (root of sum of "
      "squares)\n",
      own, others);
  raise(worst.crosstalk, others);
  bench::draw_accuracy(with.name, ties, methods, crosstalk, 1000 / with.rate_hz,
                       folder / ("accuracy-" + file + ".png"));
}

/// The largest difference over observed AUs between a marker displaced by 20 mm and the same marker missing, over half
/// a second each.
double displaced_against_missing(const SolveCase& with) {
  constexpr int kTrials = 24;
  const std::size_t length = std::min<std::size_t>(60, with.frames.size());
  Random random(17, 1);
  double largest = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::size_t begin = random.index(with.frames.size() - length + 1),
                      marker = random.index(with.rig.marker_count());
    Eigen::Vector3d direction(random.gaussian(), random.gaussian(), random.gaussian());
    const Eigen::Vector3f shift = (kPoint * direction.normalized()).cast<float>();
    std::vector<MarkerFrame> displaced(with.frames.begin() + static_cast<std::ptrdiff_t>(begin),
                                       with.frames.begin() + static_cast<std::ptrdiff_t>(begin + length));
    std::vector<MarkerFrame> missing = displaced;
    for (std::size_t f = 0; f < length; ++f) {
      Position& p = displaced[f].position_mm[marker];
      p = {p.x + shift.x(), p.y + shift.y(), p.z + shift.z()};
      missing[f].state[marker] = MarkerState::kMissing;
    }
    const auto a = solve_frame_by_frame(with.rig, with.markers, displaced, {});
    const auto b = solve_frame_by_frame(with.rig, with.markers, missing, {});
    for (std::size_t f = 0; f < length; ++f) {
      for (std::size_t i = 0; i < with.rig.au_count(); ++i) {
        if (b[f].state[i] != AuState::kObserved) continue;
        raise(largest, std::abs(a[f].intensity[i] - b[f].intensity[i]));
      }
    }
  }
  return largest;
}

void measure_truth(const Arguments& arguments, const std::vector<std::pair<std::string, Rig>>& rigs,
                   bench::BenchReport& report) {
  double kkt = 0, displaced = 0, lag = 0, joint_lag = 0;
  for (const bool is_perturbed : {false, true}) {
    Worst worst;
    for (const auto& [name, rig] : rigs) {
      bench::SolveCaseOptions options;
      options.is_perturbed = is_perturbed;
      options.seconds = arguments.seconds;
      const std::string title = name + (is_perturbed ? " perturbed" : " true");
      SolveCase with = arguments.au.empty() ? bench::make_solve_case(title, rig, options)
                                            : bench::make_solve_case(title, rig, load_au_csv(arguments.au),
                                                                     arguments.au_rate_hz, options);
      options.seconds = 0;
      const SolveCase alone = bench::make_solve_case(title, rig, bench::one_by_one(rig.au_names()), 60, options);
      measure_case(with, with, alone, worst);
      raise(displaced, displaced_against_missing(with));
    }
    const std::string truth = is_perturbed ? "perturbed truth" : "true rig";
    report.add("causal / ridge, RMSE median, " + truth, worst.causal);
    report.add("causal / ridge, RMSE p90, " + truth, worst.causal_p90);
    report.add("causal / ridge, RMSE median of AUs that move, " + truth, worst.causal_moving);
    report.add("joint / ridge, RMSE median of AUs that move, " + truth, worst.joint_moving);
    report.add("causal, crosstalk of one AU on all others, " + truth, worst.crosstalk);
    report.add("joint / ridge, RMSE median, " + truth, worst.joint);
    report.add("joint / ridge, RMSE p90, " + truth, worst.joint_p90);
    report.add("causal, least correlation median, " + truth, worst.least_correlation);
    report.add("2 % outliers / none, RMSE median, mean of rigs, " + truth,
               worst.outliers_sum / static_cast<double>(rigs.size()));
    report.add("2 % outliers / none, RMSE median, worst rig, " + truth, worst.outliers);
    raise(kkt, worst.kkt);
    raise(lag, worst.causal_lag);
    raise(joint_lag, worst.joint_lag);
  }
  report.add("causal, lag median", lag);
  report.add("joint, lag median", joint_lag);
  report.add("largest KKT residual", kkt);
  report.add("a marker 20 mm off against missing, largest AU difference", displaced);
}

int measure_all(const Arguments& arguments) {
  bench::BenchReport report("accuracy");
  const test::TemporaryFolder folder;
  const auto ict = bench::unpack_ict(folder.path());
  std::vector<std::pair<std::string, Rig>> rigs;
  for (const char* layout : {"iemocap55", "animface41"}) {
    rigs.emplace_back(std::string("builtin ") + layout, bench::rig_at_layout({}, layout));
    if (ict) rigs.emplace_back(std::string("ICT ") + layout, bench::rig_at_layout(ict, layout));
  }
  if (!ict) fmt::print(stderr, "bench accuracy: no ict_facekit.tar.xz: only the built-in face; set RISORIUS_DATA\n");
  measure_truth(arguments, rigs, report);
  bench::measure_real_takes("builtin", builtin_face(), report);
  if (ict) bench::measure_real_takes("ICT", load_ict_face(*ict), report);
  return report.finish();
}

}  // namespace
}  // namespace risorius

int main(int argc, char** argv) {
  risorius::Arguments arguments;
  CLI::App app("how true the solve is");
  app.add_option("--seconds", arguments.seconds, "of each performed take, at 120 Hz")->check(CLI::Range(1.0, 600.0));
  app.add_option("--au", arguments.au, "AU CSV that drives the face instead of the performer's script");
  app.add_option("--au-rate", arguments.au_rate_hz, "frames per second of --au")->check(CLI::Range(1.0, 2000.0));
  auto* take = app.add_option("--take", arguments.take, "look at this take only");
  take->needs(app.add_option("--rig", arguments.rig, "and this rig"));
  CLI11_PARSE(app, argc, argv);
  try {
    if (!arguments.take.empty()) {
      risorius::bench::look_at_take(arguments.take, arguments.rig);
      return 0;
    }
    return risorius::measure_all(arguments);
  } catch (const risorius::UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
