// risorius rom: the poses of a range of motion, and whether a take has them.
#pragma once

namespace CLI {
class App;
}

namespace risorius {

void add_rom_command(CLI::App& app);

}  // namespace risorius
