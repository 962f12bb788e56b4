// How subcommands name takes: a path, "builtin" for the synthetic performer, and what the file itself does not say.
#pragma once

#include <memory>
#include <string>

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

/// A file, or the built-in performer for "builtin" or "builtin:SECONDS".
std::unique_ptr<TakeReader> open_take_or_builtin(const std::string& name, const TakeOptions& options);

/// Prints the take's warnings to stderr.
void print_warnings(const TakeReader& take);

}  // namespace risorius
