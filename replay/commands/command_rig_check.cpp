// risorius rig check: what a rig can tell from a take. Exit code 0: usable, 2: it is not this take's rig.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/picture/rig_check_picture.h"
#include "replay/pipeline/take_frames.h"
#include "solve/rigs/rig_check.h"

namespace risorius {
namespace {

constexpr int kUnusable = 2;
constexpr std::size_t kMostPairs = 12;

struct CheckArguments {
  std::string rig, take_name, output;
  TakeArguments take;
};

void print_check(const RigCheck& check) {
  fmt::print("{:<12} {:>9} {:>7} {:>6} {:>6} {:>9}  {}\n", "AU", "uncertain", "alone", "seen", "peak", "at bound",
             "most like");
  for (const AuCheck& au : check.aus) {
    fmt::print("{:<12} {:>9.3f} {:>7.3f} {:>4.0f} % {:>6.2f} {:>7.0f} %  {} ({:.2f}){}\n", au.au, au.deviation,
               au.alone_deviation, 100 * au.seen_share, au.peak, 100 * au.at_bound_share, au.most_like, au.cosine,
               au.weak ? "  weakly observed" : "");
  }
  fmt::print("condition number {:.3g}; residual {:.2f} mm per marker; {} of {} frames solved\n", check.condition,
             check.residual_rms_mm, check.solved, check.frames);
  for (std::size_t i = 0; i < std::min(kMostPairs, check.confused.size()); ++i) {
    fmt::print("confounded: {} and {} (cosine {:.3f})\n", check.confused[i].first, check.confused[i].second,
               check.confused[i].cosine);
  }
  if (check.confused.size() > kMostPairs) fmt::print("and {} pairs more\n", check.confused.size() - kMostPairs);
  std::fflush(stdout);
  for (const auto& warning : check.warnings) fmt::print(stderr, "warning: {}\n", warning);
  for (const auto& problem : check.problems) fmt::print(stderr, "problem: {}\n", problem);
}

void check(const CheckArguments& arguments) {
  const Rig rig = rig_of_argument(arguments.rig);
  check_outputs({arguments.rig, path_of_take(arguments.take_name)}, {arguments.output});
  const auto take = open_take_or_builtin(arguments.take_name, arguments.take.options());
  print_warnings(*take);
  const RigCheck result = check_rig(rig, take_frames_of(*take, arguments.take_name));
  print_check(result);
  if (!arguments.output.empty()) {
    const std::string take_file = std::filesystem::path(arguments.take_name).filename().string();
    draw_rig_check(result, fmt::format("rig {} on {}", rig.name, take_file)).save_png(arguments.output);
    fmt::print("written: {}\n", arguments.output);
  }
  if (!result.problems.empty()) throw CLI::RuntimeError(kUnusable);
}

}  // namespace

void add_rig_check_command(CLI::App& rig) {
  CLI::App* command = rig.add_subcommand("check", "what a rig can tell from a take: weak and confounded AUs, markers");
  auto arguments = std::make_shared<CheckArguments>();
  command->add_option("rig", arguments->rig, "rig file, or \"builtin\"")->required();
  command->add_option("take", arguments->take_name, kTakeNames)->required();
  command->add_option("-o,--output", arguments->output, "a picture (PNG) of it");
  arguments->take.add_to(*command);
  command->callback([arguments] { check(*arguments); });
}

}  // namespace risorius
