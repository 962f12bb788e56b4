// The subcommands of the `risorius` tool. Each adds itself to the command line and returns what to run when it was
// chosen.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace risorius {

/// Adds the subcommand; its callback does the work and throws UserError. `exit_code` is what main returns.
void add_replay_command(CLI::App& app);
void add_serve_command(CLI::App& app);
void add_rig_command(CLI::App& app);
/// Part of `risorius rig`.
void add_rig_calibrate_command(CLI::App& rig);
void add_rig_refine_command(CLI::App& rig);
void add_rig_check_command(CLI::App& rig);
void add_rig_show_command(CLI::App& rig);
void add_actor_command(CLI::App& app);
void add_neutral_command(CLI::App& app);
void add_report_command(CLI::App& app);
void add_dataset_command(CLI::App& app);
void add_watch_command(CLI::App& app);
void add_control_command(CLI::App& app);
void add_keys_command(CLI::App& app);
void add_demo_command(CLI::App& app);
void add_perform_command(CLI::App& app);
void add_perform_fit_command(CLI::App& app);
void add_defects_command(CLI::App& app);
void add_clean_command(CLI::App& app);
void add_plot_command(CLI::App& app);
void add_chaos_command(CLI::App& app);

}  // namespace risorius
