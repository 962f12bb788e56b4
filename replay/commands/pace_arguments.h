// --speed and --loop, as the commands that play takes have them.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace risorius {

struct PaceArguments {
  std::string speed = "1";
  bool loop = false;

  void add_to(CLI::App& command);
  /// 0 for "max". Throws UserError naming the option.
  double speed_factor() const;
};

}  // namespace risorius
