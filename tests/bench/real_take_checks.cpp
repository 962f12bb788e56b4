#include "bench/real_take_checks.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <vector>

#include "bench/component_ceiling.h"
#include "bench/solved_series.h"
#include "replay/pipeline/neutral.h"
#include "replay/takes/take.h"
#include "solve/faces/landmark_map.h"
#include "solve/faces/rig_fit.h"
#include "solve/joint/take_solver.h"
#include "support/test_data.h"

namespace risorius::bench {
namespace {

std::vector<MarkerFrame> frames_of(TakeReader& take) {
  std::vector<MarkerFrame> frames;
  MarkerFrame frame;
  while (take.next(frame)) frames.push_back(frame);
  return frames;
}

/// Scored on the second half, the components learned on the first.
struct LeftOut {
  double by_rig = 0, by_components = 0;  ///< shares of the hidden markers' motion
};

LeftOut left_out_of(const Rig& rig, const std::string& place, const MarkerSet& markers,
                    const std::vector<MarkerFrame>& frames) {
  const auto middle = frames.begin() + static_cast<std::ptrdiff_t>(frames.size() / 2);
  const TakeFrames first{place, markers, {frames.begin(), middle}}, second{place, markers, {middle, frames.end()}};
  const auto draws = hidden_draws(rig);
  return {left_out_energy(rig, second, draws).explained(),
          component_ceiling(rig, first, second, draws, rig.au_count()).explained()};
}

struct RealTake {
  const char *name, *file;
  std::uint64_t neutral_first, neutral_last;
  std::vector<int> absent;  // AU numbers
};

/// What must be absent. Blinks (AU45) are no ghosts: the lids' markers of both takes dip by 4 to 8 mm, as one sees in
/// the raw positions.
const std::vector<RealTake>& real_takes() {
  static const std::vector<RealTake> kTakes{{"jaw", "animface/jaw.c3d", 20, 90, {1, 2, 4, 5, 7, 9}},
                                            {"eyebrows",
                                             "animface/eyebrows.c3d",
                                             20,
                                             120,
                                             {10, 12, 13, 14, 15, 16, 17, 18, 20, 22, 24, 25, 27, 28, 29, 30, 34}}};
  return kTakes;
}

int au_number(const std::string& name) { return name.starts_with("AU") ? std::atoi(name.c_str() + 2) : 0; }

void measure_real(const RealTake& real, const std::string& face_name, const FaceModel& face, BenchReport& report) {
  const auto take = open_take(test::data_folder() / real.file);
  const Neutral neutral = neutral_of(*take, real.neutral_first, real.neutral_last);
  const Rig rig = fit_rig(face, neutral.marker_names, neutral.position_mm, find_landmark_map("animface41")).rig;
  take->rewind();
  const std::vector<MarkerFrame> frames = frames_of(*take);
  const auto aus = static_cast<Eigen::Index>(rig.au_count());
  const Solved solved = table_of(solve_frame_by_frame(rig, take->info().markers, frames, {}), aus);
  double largest = 0;
  std::string which;
  for (Eigen::Index i = 0; i < aus; ++i) {
    const std::string& name = rig.aus[static_cast<std::size_t>(i)].name;
    if (std::find(real.absent.begin(), real.absent.end(), au_number(name)) == real.absent.end()) continue;
    if (solved.x.col(i).maxCoeff() <= largest) continue;
    largest = solved.x.col(i).maxCoeff();
    which = name;
  }
  const LeftOut energy = left_out_of(rig, real.file, take->info().markers, frames);
  const std::string title = fmt::format("{}, {} face", real.name, face_name);
  fmt::print(
      "{}: largest absent AU {} {:.3f}; left-out energy {:.1f} %, by at most {} components {:.1f} %; largest KKT "
      "{:.1e}\n",
      title, which, largest, 100 * energy.by_rig, rig.au_count(), 100 * energy.by_components, solved.largest_kkt);
  std::fflush(stdout);
  report.add("largest absent AU, " + title, largest);
  report.add("left-out energy, unrefined rig, " + title, 100 * energy.by_rig);
  report.add("left-out energy / components', unrefined rig, " + title, energy.by_rig / energy.by_components);
}

}  // namespace

void measure_real_takes(const std::string& face_name, const FaceModel& face, BenchReport& report) {
  for (const RealTake& real : real_takes()) {
    if (test::data_folder().empty() || !std::filesystem::exists(test::data_folder() / real.file)) continue;
    measure_real(real, face_name, face, report);
  }
}

void look_at_take(const std::filesystem::path& take_path, const std::filesystem::path& rig_path) {
  const Rig rig = load_rig(rig_path);
  const auto take = open_take(take_path);
  const std::vector<MarkerFrame> frames = frames_of(*take);
  const std::vector<AuFrame> causal = solve_frame_by_frame(rig, take->info().markers, frames, {});
  const std::vector<AuFrame> joint = TakeSolver(rig, {}).solve(take->info().markers, frames);
  const auto aus = static_cast<Eigen::Index>(rig.au_count());
  const Solved c = table_of(causal, aus), j = table_of(joint, aus);
  fmt::print("{:12} {:>9} {:>9} {:>9} {:>9}\n", "", "causal", "causal", "joint", "joint");
  fmt::print("{:12} {:>9} {:>9} {:>9} {:>9}\n", "AU", "largest", "mean", "largest", "mean");
  for (Eigen::Index i = 0; i < aus; ++i) {
    fmt::print("{:12} {:9.3f} {:9.3f} {:9.3f} {:9.3f}\n", rig.aus[static_cast<std::size_t>(i)].name,
               c.x.col(i).maxCoeff(), c.x.col(i).mean(), j.x.col(i).maxCoeff(), j.x.col(i).mean());
  }
  const LeftOut energy = left_out_of(rig, take_path.string(), take->info().markers, frames);
  fmt::print(
      "largest KKT: causal {:.1e}, joint {:.1e}\nleft-out energy, second half: {:.1f} %; by at most {} components of "
      "the first "
      "half: {:.1f} %\n",
      c.largest_kkt, j.largest_kkt, 100 * energy.by_rig, rig.au_count(), 100 * energy.by_components);
}

}  // namespace risorius::bench
