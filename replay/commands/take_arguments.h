// The options of subcommands that read takes: what the file itself does not say.
#pragma once

#include <string>

#include "replay/commands/take_argument.h"
#include "replay/takes/take.h"

namespace CLI {
class App;
}

namespace risorius {

/// --units, --axes and --rate, as typed.
struct TakeArguments {
  std::string units, axes;
  double rate_hz = 0;

  void add_to(CLI::App& command);
  /// Throws UserError naming the option.
  TakeOptions options() const;
};

/// Prints the take's warnings to stderr.
void print_warnings(const TakeReader& take);

}  // namespace risorius
