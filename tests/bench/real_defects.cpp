#include "bench/real_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>

#include "capture/repair/position_vector.h"
#include "replay/picture/repair_picture.h"
#include "replay/pipeline/clean_take.h"

namespace risorius::bench {
namespace {

constexpr std::array kTakes{"kinect/a_affirmative_datapoints.txt", "kinect/a_wh_question_datapoints.txt",
                            "kinect/a_yn_question_datapoints.txt", "c3d/phasespace_sample.c3d"};
constexpr std::size_t kDrawn = 4;
/// Farther between two frames, on a head held still, no skin goes: at 15 frames a second a jaw falls 30 mm.
constexpr double kLeapMm = 40;

bool has_place(const MarkerFrame& frame, std::size_t i) noexcept {
  return frame.state[i] == MarkerState::kMeasured || frame.state[i] == MarkerState::kFilled;
}

/// Steps between frames in which the marker has a place, sorted, mm.
std::vector<double> steps_mm(const std::vector<MarkerFrame>& frames) {
  std::vector<double> steps;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    for (std::size_t i = 0; i < frames[f].count; ++i) {
      if (!has_place(frames[f], i) || !has_place(frames[f - 1], i)) continue;
      steps.push_back((to_vector(frames[f].position_mm[i]) - to_vector(frames[f - 1].position_mm[i])).norm());
    }
  }
  std::ranges::sort(steps);
  return steps;
}

double leaps_of(const std::vector<double>& sorted_steps) {
  return static_cast<double>(sorted_steps.end() - std::ranges::upper_bound(sorted_steps, kLeapMm));
}

void bench_take(const std::filesystem::path& path, BenchReport& report) {
  const auto reader = open_take(path);
  CleanedTake cleaned = clean_take(*reader, {});
  const MarkerSet& set = reader->info().markers;
  hold_head_still(cleaned, set);
  const auto before = steps_mm(cleaned.before), after = steps_mm(cleaned.after);
  const double samples = static_cast<double>(cleaned.after.size() * set.names.size());
  double rejected = 0;
  for (std::size_t r = 1; r < cleaned.rejected.size(); ++r) rejected += static_cast<double>(cleaned.rejected[r]);
  const auto percent = [samples](double count) { return 100 * count / samples; };
  const std::string name = "real defects: " + path.stem().string();
  report.add(name + ": missing", percent(static_cast<double>(cleaned.missing)));
  report.add(name + ": rejected", percent(rejected));
  report.add(name + ": filled", percent(static_cast<double>(cleaned.filled)));
  report.add(name + ": left missing", percent(static_cast<double>(cleaned.left_missing)));
  report.add(name + ": largest step before", before.back());
  report.add(name + ": largest step after", after.back());
  report.add(name + ": steps beyond 40 mm before", leaps_of(before));
  report.add(name + ": steps beyond 40 mm after", leaps_of(after));
  fmt::print(
      "{:<26} {:6} frames x {:3}: missing {:.2f} %, rejected {:.2f} %, filled {:.2f} %, left {:.2f} %; largest step "
      "{:.0f} -> {:.0f} mm, beyond {:g} mm {} -> {}\n",
      path.stem().string(), cleaned.after.size(), set.names.size(), percent(static_cast<double>(cleaned.missing)),
      percent(rejected), percent(static_cast<double>(cleaned.filled)),
      percent(static_cast<double>(cleaned.left_missing)), before.back(), after.back(), kLeapMm, leaps_of(before),
      leaps_of(after));
  const std::string picture = fmt::format("{}/build/bench/repair_{}.png", RISORIUS_SOURCE_DIR, path.stem().string());
  repair_picture(cleaned.before, cleaned.after, set, most_repaired(cleaned, set, kDrawn)).save_png(picture);
}

}  // namespace

void bench_real_defects(const std::filesystem::path& data_folder, BenchReport& report) {
  fmt::print("\n== real defects, offline, the head held still\n");
  for (const char* take : kTakes) bench_take(data_folder / take, report);
}

}  // namespace risorius::bench
