// risorius defects: spoils a take as an optical system does, and says where.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <limits>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/commands/take_arguments.h"
#include "replay/commands/take_output.h"
#include "replay/performer/marker_defects.h"
#include "replay/performer/truth_files.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

struct DefectArguments {
  std::string take, output, truth;
  TakeArguments take_arguments;
  DefectOptions defects;
  std::uint64_t seed = 1;
};

/// Each marker's first position, to know who is whose neighbour; a marker that is never seen is nobody's.
Eigen::Matrix3Xd first_positions(TakeReader& take) {
  const std::size_t count = take.info().markers.names.size();
  Eigen::Matrix3Xd first(3, static_cast<Eigen::Index>(count));
  for (Eigen::Index m = 0; m < first.cols(); ++m)
    first.col(m) = Eigen::Vector3d::Constant(1e6 + 1e5 * static_cast<double>(m));
  std::vector<char> seen(count, 0);
  std::size_t left = count;
  const auto frame = std::make_unique<MarkerFrame>();
  while (left > 0 && take.next(*frame)) {
    for (std::size_t m = 0; m < count; ++m) {
      if (seen[m] != 0 || frame->state[m] == MarkerState::kMissing) continue;
      const Position& p = frame->position_mm[m];
      first.col(static_cast<Eigen::Index>(m)) = Eigen::Vector3d(p.x, p.y, p.z);
      seen[m] = 1;
      --left;
    }
  }
  take.rewind();
  return first;
}

void spoil(const DefectArguments& arguments) {
  check_outputs({path_of_take(arguments.take)}, {arguments.output, arguments.truth});
  check_take_output(arguments.output);
  const auto take = open_take_or_builtin(arguments.take, arguments.take_arguments.options());
  print_warnings(*take);
  MarkerSet set = take->info().markers;
  // Positions are mm and LUF by now, whatever the file had.
  set.mm_per_unit = 1;
  set.axes = Axes{};
  MarkerDefects defects(first_positions(*take), set.rate_hz, arguments.defects, arguments.seed);
  const auto output = make_take_writer(arguments.output, set);
  std::unique_ptr<CauseWriter> truth;
  if (!arguments.truth.empty()) truth = std::make_unique<CauseWriter>(arguments.truth);
  const auto clean = std::make_unique<MarkerFrame>(), observed = std::make_unique<MarkerFrame>();
  ProgressLine progress("defects", "frames");
  std::uint64_t done = 0;
  std::array<std::uint64_t, 256> count{};
  while (take->next(*clean)) {
    *observed = *clean;
    defects.apply(*clean, *observed);
    output->write(*observed);
    for (const DefectCause cause : defects.causes()) ++count[static_cast<unsigned char>(cause)];
    if (truth) truth->write(clean->header.sequence, defects.causes());
    progress.show(++done, take->info().frame_count.value_or(0));
  }
  progress.finish(done);
  output->finish();
  if (truth) truth->finish();
  fmt::print(
      "{}: {} frames; samples good {}, occluded {}, in occluded regions {}, jumps {}, ghosts {}, swaps {}, "
      "missing before {}\n",
      arguments.output, done, count['.'], count['o'], count['r'], count['j'], count['g'], count['s'], count['-']);
}

}  // namespace

void add_defects_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("defects", "spoil a take: occlusions, false tracks, noise, with the truth of each sample");
  auto arguments = std::make_shared<DefectArguments>();
  command->add_option("take", arguments->take, kTakeNames)->required();
  command->add_option("-o,--output", arguments->output, "take to write (.c3d, .csv)")->required();
  command->add_option("--truth", arguments->truth, "CSV to write: frame, one letter per marker");
  command->add_option("--seed", arguments->seed, "same seed, same bytes")->check(whole_number())->capture_default_str();
  DefectOptions& defects = arguments->defects;
  command->add_option("--noise", defects.noise_mm, "white noise, mm per axis")
      ->check(number_between(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--coloured-noise", defects.coloured_noise_mm, "noise that lasts about 0.25 s, mm per axis")
      ->check(number_between(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--occlude", defects.occlusion_share, "share of samples in gaps of single markers")
      ->check(number_between(0.0, 0.5))
      ->capture_default_str();
  command->add_option("--regions", defects.regions_per_minute, "occluded regions of 40 mm, per minute")
      ->check(number_between(0.0, 60.0))
      ->capture_default_str();
  command->add_option("--outliers", defects.false_track_share, "share of visible samples that are false")
      ->check(number_between(0.0, 0.2))
      ->capture_default_str();
  arguments->take_arguments.add_to(*command);
  command->callback([arguments] { spoil(*arguments); });
}

}  // namespace risorius
