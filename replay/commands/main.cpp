// risorius: everything offline, by subcommand.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fmt/format.h>

#include "capture/version.h"
#include "replay/commands/command_rom.h"
#include "replay/commands/command_study.h"
#include "replay/commands/command_transition.h"
#include "replay/commands/commands.h"
#include "replay/commands/session_commands.h"
#include "replay/commands/unknown_subcommand.h"
#include "replay/unfinished_paths.h"

int main(int argc, char** argv) {
  CLI::App app("Risorius: facial motion capture to FACS action units, offline tools. The live service is risoriusd.");
  app.set_version_flag("--version", fmt::format("risorius {} ({})", risorius::kVersion, risorius::kInstructionSet));
  app.require_subcommand(1);
  risorius::add_demo_command(app);
  risorius::add_perform_command(app);
  risorius::add_perform_fit_command(app);
  risorius::add_defects_command(app);
  risorius::add_clean_command(app);
  risorius::add_plot_command(app);
  risorius::add_replay_command(app);
  risorius::add_serve_command(app);
  risorius::add_chaos_command(app);
  risorius::add_rig_command(app);
  risorius::add_actor_command(app);
  risorius::add_neutral_command(app);
  risorius::add_rom_command(app);
  risorius::add_dataset_command(app);
  risorius::add_report_command(app);
  risorius::add_info_command(app);
  risorius::add_recover_command(app);
  risorius::add_verify_command(app);
  risorius::add_transition_command(app);
  risorius::add_study_command(app);
  risorius::add_watch_command(app);
  risorius::add_control_command(app);
  risorius::add_keys_command(app);
  risorius::remove_unfinished_paths_on_signals();
  try {
    risorius::refuse_unknown_subcommand(app, argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "risorius: {}\n", error.what());
    return 1;
  }
}
