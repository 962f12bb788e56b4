#include "replay/commands/clean_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "capture/errors.h"
#include "replay/commands/number_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/progress_line.h"
#include "solve/rigs/rig_motion.h"

namespace risorius {
namespace {

constexpr double kProgressSteps = 100;

StabiliserWeights stabilisers_of(const Rig& rig) {
  StabiliserWeights weights;
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    const double weight = rig.stabiliser_weight[static_cast<Eigen::Index>(m)];
    if (weight > 0) weights.emplace_back(rig.marker_names[m], weight);
  }
  return weights;
}

}  // namespace

void CleanArguments::add_to(CLI::App& command) {
  command.add_option("take", take, kTakeNames)->required();
  command.add_flag("--causal", options.is_causal, "as the live service does it (default: from past and future)");
  command
      .add_option("--lookahead", options.lookahead_frames, "with --causal: frames that each frame waits for later ones")
      ->check(CLI::Range(0, 64));
  command.add_option(
      "--baseline", options.baseline,
      "fill by another method: linear, linear_head, cubic, kalman, pca, hold, damped_velocity, online_pca");
  command.add_option("--max-gap", max_gap_s, "seconds; a longer gap stays missing (default 10; 2 with --causal)")
      ->check(number_between(1e-3, 3600.0));
  command.add_option("--rig", rig,
                     "rig of this face: its stabilisers hold the head still, its AUs say how hidden markers move "
                     "(default: the take alone)");
  take_arguments.add_to(command);
}

CleanedTake CleanArguments::run(MarkerSet& set) {
  const auto reader = open_take_or_builtin(take, take_arguments.options());
  print_warnings(*reader);
  if (!rig.empty()) {
    const Rig known = rig_of_argument(rig);
    options.head_frame.stabilisers = stabilisers_of(known);
    options.known_motion = motion_of(known);
  }
  options.max_gap_ns = static_cast<std::int64_t>(max_gap_s * 1e9);
  set = reader->info().markers;
  set.mm_per_unit = 1;
  set.axes = Axes{};
  for (const std::string& name : needed_markers) {
    if (std::ranges::find(set.names, name) == set.names.end())
      throw UserError(take, fmt::format("has no marker \"{}\"", name),
                      fmt::format("there are: {}", fmt::join(set.names, ", ")));
  }
  ProgressLine progress("repair", "%");
  CleanedTake cleaned = clean_take(*reader, options, [&](double share) {
    progress.show(static_cast<std::uint64_t>(kProgressSteps * share), static_cast<std::uint64_t>(kProgressSteps));
  });
  progress.finish(static_cast<std::uint64_t>(kProgressSteps));
  return cleaned;
}

}  // namespace risorius
