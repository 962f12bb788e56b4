#include "replay/commands/clean_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "capture/errors.h"
#include "capture/repair/known_motion.h"
#include "capture/repair/position_vector.h"
#include "replay/commands/number_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/progress_line.h"
#include "solve/rigs/rig_motion.h"

namespace risorius {
namespace {

constexpr double kProgressSteps = 100;

/// The rig is of this take, or it is said that it is not. `frames`: before repair.
void check_rig(const std::string& rig, const std::shared_ptr<const KnownMotion>& motion, const MarkerSet& set,
               const std::vector<MarkerFrame>& frames) {
  KnownModes modes;
  modes.use(motion, set.names);
  for (const MarkerFrame& frame : frames) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      if (frame.state[i] == MarkerState::kMeasured) modes.see(i, to_vector(frame.position_mm[i]));
    }
    modes.align();
    if (modes.aligned() || modes.refused()) break;
  }
  if (modes.aligned()) return;
  fmt::print(
      stderr,
      "warning: {}: the rig does not fit this take's markers (another actor, another layout, or mirrored): gaps are "
      "filled without it\n",
      rig);
}

/// Why some markers have no fills at all.
void warn_of_unfillable(const CleanedTake& cleaned, const MarkerSet& set) {
  std::vector<std::string> never_seen;
  for (std::size_t i = 0; i < set.names.size(); ++i) {
    const auto is_seen = [i](const MarkerFrame& f) { return f.state[i] == MarkerState::kMeasured; };
    if (std::ranges::none_of(cleaned.after, is_seen)) never_seen.push_back(set.names[i]);
  }
  if (!never_seen.empty()) {
    fmt::print(stderr, "warning: never seen, and so left missing: {}\n", fmt::join(never_seen, ", "));
  }
  if (cleaned.filled == 0 && cleaned.left_missing > 0 && set.names.size() < never_seen.size() + 3) {
    fmt::print(stderr,
               "warning: nothing is filled: fewer than three markers are seen, and the head's pose is not known\n");
  }
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
                     "rig of this face: its AUs say how hidden markers move "
                     "(default: the take alone)");
  take_arguments.add_to(command);
}

CleanedTake CleanArguments::run(MarkerSet& set) {
  const auto reader = open_take_or_builtin(take, take_arguments.options());
  print_warnings(*reader);
  if (!rig.empty()) {
    options.known_motion = motion_of(rig_of_argument(rig));
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
  if (!rig.empty()) check_rig(rig, options.known_motion, set, cleaned.before);
  warn_of_unfillable(cleaned, set);
  return cleaned;
}

}  // namespace risorius
