// risorius transition: see command_transition.cpp.
#pragma once

namespace CLI {
class App;
}

namespace risorius {

void add_transition_command(CLI::App& app);

}  // namespace risorius
