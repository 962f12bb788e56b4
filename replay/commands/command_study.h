// risorius study: see command_study.cpp.
#pragma once

namespace CLI {
class App;
}

namespace risorius {

void add_study_command(CLI::App& app);

}  // namespace risorius
