// risorius rig refine: takes of the actor make the rig the actor's own.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <vector>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/pipeline/take_frames.h"
#include "replay/progress_line.h"
#include "solve/rigs/left_out_markers.h"
#include "solve/rigs/rig_refine.h"

namespace risorius {
namespace {

constexpr std::size_t kFolds = 5;

struct RefineArguments {
  std::string rig, output, name;
  std::vector<std::string> takes;
  bool keeps_neutral = false, skips_check = false;
  RigRefineOptions options;
  TakeArguments take;
};

void print_refinement(const RigRefinement& result) {
  fmt::print("{:<8} {:>6} {:>8} {:>9} {:>8} {:>6}\n", "AU", "peak", "active", "moved", "turned", "gain");
  for (const AuRefinement& au : result.aus) {
    if (!au.informed) continue;
    fmt::print("{:<8} {:>6.2f} {:>6.1f} s {:>6.2f} mm {:>4.0f} deg {:>6.2f}{}\n", au.au, au.peak, au.active_s,
               au.moved_mm, au.turned_degrees, au.gain, au.guarded ? "  held back" : "");
  }
  std::string kept;
  for (const AuRefinement& au : result.aus) {
    if (!au.informed) kept += " " + au.au;
  }
  if (!kept.empty()) fmt::print("not in the takes, unchanged:{}\n", kept);
  if (!result.stabilisers_dropped.empty()) {
    fmt::print("stabilisers that move with the face in these takes: {}; in their place: {}\n",
               fmt::join(result.stabilisers_dropped, " "), fmt::join(result.stabilisers_added, " "));
  }
  fmt::print("neutral: moved by up to {:.2f} mm ({})\n", result.neutral_moved_mm, result.neutral_moved_marker);
  fmt::print("residual on these takes, rms per marker: {:.2f} mm before, {:.2f} mm after {} rounds\n",
             result.residual_before_mm, result.residual_after_mm, result.rounds);
}

/// Halves of each take in time: what is refined on the first is scored on the second, and the other way round.
struct Halves {
  std::vector<TakeFrames> first, second;
};

Halves halves_of(const std::vector<TakeFrames>& takes) {
  Halves halves;
  for (const TakeFrames& take : takes) {
    const auto middle = take.frames.begin() + static_cast<std::ptrdiff_t>(take.frames.size() / 2);
    halves.first.push_back({take.place + ", first half", take.markers, {take.frames.begin(), middle}});
    halves.second.push_back({take.place + ", second half", take.markers, {middle, take.frames.end()}});
  }
  return halves;
}

void add(LeftOutEnergy& sum, const LeftOutEnergy& part) {
  sum.moved_mm2 += part.moved_mm2;
  sum.left_mm2 += part.left_mm2;
  sum.samples += part.samples;
}

/// What refining on one half does for the other: markers that the solve is not shown.
void print_held_out(const Rig& start, const std::vector<TakeFrames>& takes, const RigRefineOptions& options) {
  const Halves halves = halves_of(takes);
  const auto folds = marker_folds(start, kFolds);
  LeftOutEnergy before, after;
  ProgressLine progress("held-out check", "steps");
  const std::size_t all = 2 * (1 + 2 * takes.size());
  std::size_t done = 0;
  for (const bool is_swapped : {false, true}) {
    const auto& learned = is_swapped ? halves.second : halves.first;
    const auto& scored = is_swapped ? halves.first : halves.second;
    Rig refined;
    try {
      refined = refine_rig(start, learned, options).rig;
    } catch (const UserError& error) {
      progress.finish(done);
      fmt::print("held-out check: not possible, one half tells too little: {}\n", error.what());
      return;
    }
    progress.show(++done, all);
    for (const TakeFrames& take : scored) {
      add(before, left_out_energy(start, take, folds, options.solve));
      progress.show(++done, all);
      add(after, left_out_energy(refined, take, folds, options.solve));
      progress.show(++done, all);
    }
  }
  progress.finish(done);
  fmt::print(
      "held out (refined on one half of the time, scored on the other, on markers that the solve is not shown):\n"
      "  {:.1f} % of their motion foreseen before, {:.1f} % after; off by {:.2f} mm rms before, {:.2f} mm after\n",
      100 * before.explained(), 100 * after.explained(), std::sqrt(before.left_mm2 / std::max(1.0, before.samples)),
      std::sqrt(after.left_mm2 / std::max(1.0, after.samples)));
  if (after.left_mm2 >= before.left_mm2) {
    fmt::print(stderr, "warning: on the other half the refined rig is no better; more or longer takes may help\n");
  }
}

void refine(const RefineArguments& arguments) {
  const Rig start = rig_of_argument(arguments.rig);
  std::vector<std::filesystem::path> inputs{arguments.rig};
  for (const std::string& take : arguments.takes) inputs.push_back(path_of_take(take));
  check_outputs(inputs, {arguments.output});
  RigRefineOptions options = arguments.options;
  if (arguments.keeps_neutral) options.prior.neutral_mm = 0;
  std::vector<TakeFrames> takes;
  for (const std::string& name : arguments.takes) {
    const auto take = open_take_or_builtin(name, arguments.take.options());
    print_warnings(*take);
    takes.push_back(take_frames_of(*take, name));
  }
  ProgressLine progress("refining", "frames");
  std::size_t frames = 0;
  RigRefinement result = refine_rig(start, takes, options, [&](std::size_t done, std::size_t of) {
    frames = done;
    progress.show(done, of);
  });
  progress.finish(frames);
  result.rig.name = arguments.name.empty() ? std::filesystem::path(arguments.output).stem().string() : arguments.name;
  std::string sources;
  for (const std::string& name : arguments.takes) sources += " " + std::filesystem::path(name).filename().string();
  result.rig.source = fmt::format("refined on{}, {} frames; {}", sources, result.frames, start.source);
  save_rig(result.rig, arguments.output);
  print_refinement(result);
  for (const auto& warning : result.warnings) fmt::print(stderr, "warning: {}\n", warning);
  fmt::print("written: {}\n", arguments.output);
  std::fflush(stdout);
  if (!arguments.skips_check) print_held_out(start, takes, options);
}

}  // namespace

void add_rig_refine_command(CLI::App& rig) {
  CLI::App* command = rig.add_subcommand("refine", "make a rig the actor's own, by takes of the actor");
  auto arguments = std::make_shared<RefineArguments>();
  command->add_option("rig", arguments->rig, "rig file, or \"builtin\"")->required();
  command->add_option("takes", arguments->takes, std::string(kTakeNames) + ": best a range of motion")->required();
  command->add_option("-o,--output", arguments->output, "rig file to write (JSON)")->required();
  command->add_option("--name", arguments->name, "the rig's name (default: from the file name)");
  command->add_option("--rounds", arguments->options.rounds, "of solve and update, at most")
      ->check(number_between(1, 100))
      ->capture_default_str();
  command
      ->add_option("--freedom", arguments->options.prior.share,
                   "how far an AU may differ from the start, as a share of its own motion (one standard deviation)")
      ->check(number_between(0.01, 2))
      ->capture_default_str();
  command->add_flag("--keep-neutral", arguments->keeps_neutral, "leave the neutral as it is");
  command->add_flag("--no-check", arguments->skips_check, "no held-out check (it takes twice the time)");
  arguments->take.add_to(*command);
  command->callback([arguments] { refine(*arguments); });
}

}  // namespace risorius
