#include "replay/commands/command_rom.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "replay/commands/rig_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/picture/rig_pictures.h"
#include "replay/pipeline/take_frames.h"
#include "solve/rigs/rom_check.h"

namespace risorius {
namespace {

struct RomArguments {
  std::string rig, take_name;
  TakeArguments take;
};

void print_prompts(const Rig& rig) {
  fmt::print("From rest to as far as it goes, hold a second, back to rest; each on its own:\n");
  int number = 0;
  for (const RigAu& au : rig.aus) {
    const std::string name = facs_name(au.name);
    fmt::print("{:>3}. {:<8} {}\n", ++number, au.name, name);
  }
  fmt::print("then: risorius rom --rig RIG TAKE says which of them the take has\n");
}

void check(const RomArguments& arguments) {
  const Rig rig = rig_of_argument(arguments.rig);
  if (arguments.take_name.empty()) {
    print_prompts(rig);
    return;
  }
  const auto take = open_take_or_builtin(arguments.take_name, arguments.take.options());
  print_warnings(*take);
  const auto poses = check_range_of_motion(rig, take_frames_of(*take, arguments.take_name));
  fmt::print("{:<8} {:>5} {:>9} {:>11}  {:<16} {}\n", "AU", "peak", "at", "other side", "with", "");
  std::size_t seen = 0;
  for (const PoseCheck& pose : poses) {
    seen += pose.is_seen;
    const std::string verdict = !pose.is_seen      ? "not seen: again"
                                : pose.is_lopsided ? "weaker than the other side"
                                                   : "";
    fmt::print("{:<8} {:>5.2f} {:>7.2f} s {:>11}  {:<16} {}\n", pose.au, pose.peak, pose.peak_s,
               std::isnan(pose.other_side_peak) ? "-" : fmt::format("{:.2f}", pose.other_side_peak),
               pose.company.empty() ? "" : fmt::format("{} {:.2f}", pose.company, pose.company_intensity), verdict);
  }
  fmt::print("{} of {} AUs seen\n", seen, poses.size());
}

}  // namespace

void add_rom_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("rom", "the poses of a range of motion; with a take: which of them it has");
  auto arguments = std::make_shared<RomArguments>();
  command->add_option("--rig", arguments->rig, "rig file, actor folder, or \"builtin\"")->required();
  command->add_option("take", arguments->take_name, kTakeNames);
  arguments->take.add_to(*command);
  command->callback([arguments] { check(*arguments); });
}

}  // namespace risorius
