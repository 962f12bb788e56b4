// Time per frame of the live QP path against bounded Ceres and a plain Gram active set, in alternating blocks on the
// same frames: smooth intensities, 0.2 mm noise, warm start. Then the whole AuSolver stage, and both over the number of
// markers and of AUs (build/bench/solve-cost.png). Medians and ratios (EVALUATION section 2). Usage: bench_solve
// [frames per size]
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <vector>

#include "bench/bench_report.h"
#include "bench/solve_methods.h"
#include "replay/picture/canvas.h"
#include "replay/picture/plot.h"
#include "solve/au_solver.h"

namespace risorius {
namespace {

using bench::BoundedCeres;
using bench::LivePath;
using bench::make_problem;
using bench::PlainGram;
using bench::Problem;
using bench::UnconstrainedClamped;
using Clock = std::chrono::steady_clock;

constexpr int kBlock = 20;  // frames of one method before the next has its turn

double percentile(std::vector<double> values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

struct Method {
  const char* name;
  std::function<void(std::size_t)> solve;
  const Eigen::VectorXd* x;
  std::vector<double> us = {};
  double worst_difference = 0;  // from the live path's solution
};

void print_table(const std::vector<Method>& methods) {
  const double unit = percentile(methods.front().us, 0.5);
  for (const Method& method : methods) {
    const std::string difference = method.x == nullptr ? "-" : fmt::format("{:.1e}", method.worst_difference);
    fmt::print("  {:28} median {:9.1f} us  p99 {:9.1f} us  ratio to live {:7.2f}  largest difference {}\n", method.name,
               percentile(method.us, 0.5), percentile(method.us, 0.99), percentile(method.us, 0.5) / unit, difference);
  }
}

/// Alternating blocks of frames, so that a busy machine slows all methods alike.
void run_in_blocks(std::vector<Method>& methods, std::size_t frames, std::size_t aus) {
  std::vector<Eigen::VectorXd> solutions(frames, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(aus)));
  for (std::size_t start = 0; start < frames; start += kBlock) {
    for (Method& method : methods) {
      for (std::size_t f = start; f < std::min(start + kBlock, frames); ++f) {
        const Clock::time_point begin = Clock::now();
        method.solve(f);
        method.us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
        if (&method == &methods.front()) solutions[f] = *method.x;
        if (method.x == nullptr) continue;
        method.worst_difference = std::max(method.worst_difference, (*method.x - solutions[f]).cwiseAbs().maxCoeff());
      }
    }
  }
}

struct Stage {
  explicit Stage(const Problem& p) : problem(p), solver(p.rig) { solver.use_marker_set(test::marker_set_of(p.rig)); }
  void solve(std::size_t frame) {
    solver.push(problem.frames[frame]);
    solver.pop(out);
    largest_kkt = std::max(largest_kkt, out.kkt_residual);
  }
  const Problem& problem;
  AuSolver solver;
  AuFrame out;
  double largest_kkt = 0;
};

void measure(int markers, int aus, int frames, bench::BenchReport& report) {
  const Problem p = make_problem(markers, aus, frames);
  LivePath live(p), occluded(p);
  PlainGram plain(p);
  BoundedCeres bounded(p);
  UnconstrainedClamped clamped(p);
  Stage stage(p);
  std::vector<Method> methods;
  methods.push_back({"live QP path (Ceres inside)", [&](std::size_t f) { live.solve(f); }, &live.x});
  methods.push_back({"plain Gram active set", [&](std::size_t f) { plain.solve(f); }, &plain.x});
  methods.push_back(
      {"live QP path, 5 % missing", [&](std::size_t f) { occluded.solve_with_5_percent_missing(f); }, nullptr});
  methods.push_back({"bounded ceres::Problem", [&](std::size_t f) { bounded.solve(f); }, &bounded.x});
  methods.push_back({"whole AuSolver stage", [&](std::size_t f) { stage.solve(f); }, nullptr});
  methods.push_back({"unconstrained, clamped", [&](std::size_t f) { clamped.solve(f); }, &clamped.x});
  run_in_blocks(methods, p.y.size(), static_cast<std::size_t>(aus));
  fmt::print("{} markers x {} AUs, {} frames, {:.2f} free sets per frame, largest KKT residual of the stage {:.1e}\n",
             markers, aus, frames, static_cast<double>(live.free_sets) / frames, stage.largest_kkt);
  print_table(methods);
  const auto median = [&](std::size_t method) { return percentile(methods[method].us, 0.5); };
  const std::string size = fmt::format("{}x{}", markers, aus);
  report.add("bounded Ceres / live, " + size, median(3) / median(0));
  report.add("live / plain Gram active set, " + size, median(0) / median(1));
  report.add("5 % of the markers missing / live, " + size, median(2) / median(0));
  report.add("whole stage / live, " + size, median(4) / median(0));
  report.add("KKT residual of the stage, " + size, stage.largest_kkt);
}

/// Medians over one axis of sizes: live path, plain Gram, stage.
void plot_curve(Canvas& canvas, const PictureRectangle& where, bool over_markers, int frames) {
  const std::vector<int> sizes =
      over_markers ? std::vector{16, 32, 55, 96, 165, 256} : std::vector{8, 15, 24, 36, 52, 64};
  constexpr int kMarkers = 55, kAus = 30;
  std::array<std::vector<double>, 3> us;
  std::vector<double> x;
  for (const int size : sizes) {
    const Problem p = make_problem(over_markers ? size : kMarkers, over_markers ? kAus : size, frames);
    LivePath live(p);
    PlainGram plain(p);
    Stage stage(p);
    std::vector<Method> methods;
    methods.push_back({"live", [&](std::size_t f) { live.solve(f); }, &live.x});
    methods.push_back({"plain", [&](std::size_t f) { plain.solve(f); }, &plain.x});
    methods.push_back({"stage", [&](std::size_t f) { stage.solve(f); }, nullptr});
    run_in_blocks(methods, p.y.size(), p.rig.au_count());
    for (std::size_t i = 0; i < us.size(); ++i) us[i].push_back(percentile(methods[i].us, 0.5));
    x.push_back(size);
    fmt::print("  {:3} {}: live {:.1f} us, plain Gram {:.1f} us, stage {:.1f} us\n", size,
               over_markers ? "markers" : "AUs", us[0].back(), us[1].back(), us[2].back());
  }
  Plot plot({over_markers ? fmt::format("cost over markers, {} AUs", kAus)
                          : fmt::format("cost over AUs, {} markers", kMarkers),
             over_markers ? "markers" : "AUs", "median, us per frame"});
  const std::array names{"live QP path", "plain Gram active set", "whole stage: pose, robust weights, AUs"};
  for (std::size_t i = 0; i < us.size(); ++i) {
    plot.line(x, us[i], plot_colour(i), names[i]);
    plot.points(x, us[i], plot_colour(i));
  }
  plot.draw(canvas, where);
}

void plot_curves(int frames) {
  Canvas canvas(1180, 420);
  plot_curve(canvas, {10, 10, 570, 400}, true, frames);
  plot_curve(canvas, {590, 10, 570, 400}, false, frames);
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  canvas.save_png(folder / "solve-cost.png");
  fmt::print("written: build/bench/solve-cost.png\n");
}

}  // namespace
}  // namespace risorius

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::max(20, std::atoi(argv[1])) : 300;
  risorius::bench::BenchReport report("solve");
  for (const int aus : {15, 52}) {
    for (const int markers : {55, 165}) risorius::measure(markers, aus, frames, report);
  }
  risorius::plot_curves(std::max(20, frames / 3));
  return report.finish();
}
