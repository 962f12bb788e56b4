// The subcommands for recorded sessions: what is in a file, a whole one of a torn one, solved again. `replay` plays them.
#pragma once

namespace CLI {
class App;
}

namespace risorius {

void add_info_command(CLI::App& app);
void add_recover_command(CLI::App& app);
void add_verify_command(CLI::App& app);

}  // namespace risorius
