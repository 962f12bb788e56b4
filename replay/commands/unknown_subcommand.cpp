#include "replay/commands/unknown_subcommand.h"

#include <CLI/CLI.hpp>
#include <string>

#include "capture/errors.h"

namespace risorius {

void refuse_unknown_subcommand(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* level = &app;
  std::string place = app.get_name().empty() ? "risorius" : app.get_name();
  for (int i = 1; i < argc; ++i) {
    const auto commands = level->get_subcommands([](const CLI::App*) { return true; });
    const std::string word = argv[i];
    if (commands.empty() || word.empty() || word.front() == '-') return;  // what follows is not a subcommand's name
    const CLI::App* found = nullptr;
    std::string names;
    for (const CLI::App* command : commands) {
      if (command->get_name() == word) found = command;
      names += (names.empty() ? "" : ", ") + command->get_name();
    }
    if (found == nullptr) throw UserError(place, "\"" + shown(word) + "\" is no subcommand", "there are " + names);
    level = found;
    place += " " + word;
  }
}

}  // namespace risorius
