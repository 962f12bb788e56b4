// risorius actor: profiles that keep an actor's rig, neutrals, names and gains together.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/rig_fit_arguments.h"
#include "replay/commands/take_arguments.h"
#include "replay/pipeline/actor.h"
#include "replay/pipeline/rig_neutral.h"

namespace risorius {
namespace {

struct ActorArguments {
  std::string folder, rig, pseudonym, note, neutral;
  TakeArguments take;
};

std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::chrono::system_clock::now())); }

void make(const ActorArguments& arguments) {
  if (std::filesystem::exists(arguments.folder)) {
    throw UserError(arguments.folder, "is there already", "choose another folder, or edit its actor.json");
  }
  Actor actor{.pseudonym = arguments.pseudonym.empty() ? std::filesystem::path(arguments.folder).filename().string()
                                                       : arguments.pseudonym,
              .date = today(),
              .note = arguments.note,
              .rig = load_rig(arguments.rig)};
  save_actor(actor, arguments.folder);
  fmt::print("written: {}; use it wherever a rig is named: --rig {}\n", arguments.folder, arguments.folder);
}

void add_neutral(const ActorArguments& arguments) {
  Actor actor = load_actor(arguments.folder);
  const NeutralPlace place = parse_neutral_place(arguments.neutral);
  const auto take = open_take_or_builtin(place.range.path.string(), arguments.take.options());
  print_warnings(*take);
  const ChosenNeutral chosen = read_neutral(*take, place);
  print_warnings(chosen, place, arguments.neutral);
  const RenewedRig renewed = with_neutral(rig_of_actor(actor), chosen.neutral, chosen.place);
  ActorNeutral neutral{.date = today(), .place = chosen.place, .position_mm = {}};
  for (std::size_t m = 0; m < actor.rig.marker_count(); ++m) {
    neutral.position_mm.emplace(actor.rig.marker_names[m], renewed.rig.neutral_mm.col(static_cast<Eigen::Index>(m)));
  }
  actor.neutrals.push_back(std::move(neutral));
  save_actor(actor, arguments.folder);
  fmt::print("neutral {}: markers moved by {:.2f} mm rms against the last one, most {} by {:.2f} mm\n", chosen.place,
             renewed.moved_rms_mm, renewed.moved_most_marker, renewed.moved_most_mm);
  if (const std::string doubt = doubt_of(renewed); !doubt.empty()) fmt::print(stderr, "warning: {}\n", doubt);
}

void list(const ActorArguments& arguments) {
  const std::filesystem::path folder = arguments.folder.empty() ? "." : arguments.folder;
  if (!std::filesystem::is_directory(folder))
    throw UserError(folder.string(), "is no folder", "give the folder of the actors");
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_directory() && is_actor_folder(entry.path())) found.push_back(entry.path());
  }
  std::ranges::sort(found);
  for (const auto& path : found) {
    const Actor actor = load_actor(path);
    fmt::print("{:<24} {:<16} {}  {} markers, {} AUs, {} neutrals\n", path.string(), actor.pseudonym, actor.date,
               actor.rig.marker_count(), actor.rig.au_count(), actor.neutrals.size());
  }
  if (found.empty()) fmt::print("no actor in {} (risorius actor new FOLDER --rig RIG makes one)\n", folder.string());
}

void show(const ActorArguments& arguments) {
  const Actor actor = load_actor(arguments.folder);
  fmt::print("{}, made {}{}\n", actor.pseudonym, actor.date, actor.note.empty() ? "" : "; " + actor.note);
  fmt::print("rig: {}, {} markers, {} AUs; {}\n", actor.rig.name, actor.rig.marker_count(), actor.rig.au_count(),
             actor.rig.source);
  for (const ActorNeutral& neutral : actor.neutrals) fmt::print("neutral: {} {}\n", neutral.date, neutral.place);
  for (const auto& [tracker, marker] : actor.names) fmt::print("name: {} is {}\n", tracker, marker);
  for (const auto& [au, gain] : actor.gains) fmt::print("gain: {} times {:g}\n", au, gain);
}

}  // namespace

void add_actor_command(CLI::App& app) {
  CLI::App* actor =
      app.add_subcommand("actor", "profiles: an actor's rig, neutrals, marker names and gains in a folder");
  actor->require_subcommand(1);
  auto arguments = std::make_shared<ActorArguments>();
  CLI::App* make_command = actor->add_subcommand("new", "make a profile from a rig");
  make_command->add_option("folder", arguments->folder, "of the actor, to be made")->required();
  make_command->add_option("--rig", arguments->rig, "rig file")->required();
  make_command->add_option("--pseudonym", arguments->pseudonym, "(default: the folder's name)");
  make_command->add_option("--note", arguments->note, "anything worth keeping");
  make_command->callback([arguments] { make(*arguments); });
  CLI::App* neutral_command =
      actor->add_subcommand("neutral", "add a session's neutral: markers are put on anew each time");
  neutral_command->add_option("folder", arguments->folder, "of the actor")->required();
  neutral_command->add_option("neutral", arguments->neutral, "TAKE:FROM-TO, TAKE, or TAKE:auto")->required();
  arguments->take.add_to(*neutral_command);
  neutral_command->callback([arguments] { add_neutral(*arguments); });
  CLI::App* list_command = actor->add_subcommand("list", "the actors in a folder");
  list_command->add_option("folder", arguments->folder, "that holds actors' folders (default: here)");
  list_command->callback([arguments] { list(*arguments); });
  CLI::App* show_command = actor->add_subcommand("show", "what a profile holds");
  show_command->add_option("folder", arguments->folder, "of the actor")->required();
  show_command->callback([arguments] { show(*arguments); });
}

}  // namespace risorius
