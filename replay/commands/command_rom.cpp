#include "replay/commands/command_rom.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/rom_live.h"
#include "replay/commands/take_arguments.h"
#include "replay/picture/rig_pictures.h"
#include "replay/pipeline/take_frames.h"
#include "solve/rigs/rom_check.h"

namespace risorius {
namespace {

struct RomArguments {
  std::string rig, take_name;
  TakeArguments take;
  RomLiveArguments live;
};

void print_prompts(const Rig& rig) {
  fmt::print("From rest to as far as it goes, hold a second, back to rest; each on its own:\n");
  const std::vector<std::string> names = rig.au_names();
  int number = 0;
  for (const PromptedPose& pose : prompted_poses(names)) {
    fmt::print("{:>3}. {:<8} {}{}\n", ++number, pose.name, facs_name(pose.name),
               pose.aus.size() > 1 ? ", both sides" : "");
  }
  fmt::print(
      "then: risorius rom --rig RIG TAKE says which of them the take has\n"
      "live, one after the other, against a running daemon: risorius rom --connect tcp://127.0.0.1:7001\n");
}

void check(const RomArguments& arguments) {
  if (!arguments.live.endpoint.empty()) {
    if (!arguments.rig.empty()) {
      throw UserError("--rig " + arguments.rig, "the daemon has its own", "leave it out with --connect");
    }
    if (!arguments.take_name.empty()) {
      throw UserError("--connect and " + arguments.take_name, "a take and a running daemon at once", "choose one");
    }
    prompt_live(arguments.live);
    return;
  }
  if (arguments.rig.empty()) throw UserError("rom", "no rig", "give --rig RIG, or --connect for a running daemon");
  const Rig rig = rig_of_argument(arguments.rig);
  if (arguments.take_name.empty()) {
    print_prompts(rig);
    return;
  }
  const auto take = open_take_or_builtin(arguments.take_name, arguments.take.options());
  print_warnings(*take);
  const auto poses = check_range_of_motion(rig, take_frames_of(*take, arguments.take_name));
  print_pose_head();
  for (const PoseCheck& pose : poses) print_pose(pose);
  fmt::print("{} of {} AUs seen\n", std::ranges::count_if(poses, &PoseCheck::is_seen), poses.size());
}

}  // namespace

void add_rom_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("rom", "the poses of a range of motion; which of them a take has; or asked for live");
  auto arguments = std::make_shared<RomArguments>();
  command->add_option("--rig", arguments->rig, "rig file, actor folder, or \"builtin\"");
  command->add_option("take", arguments->take_name, kTakeNames);
  arguments->take.add_to(*command);
  arguments->live.add_to(*command);
  command->callback([arguments] { check(*arguments); });
}

}  // namespace risorius
