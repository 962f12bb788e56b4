// How subcommands name takes: a path, "builtin" for the synthetic performer, and what the file itself does not say.
#pragma once

#include <filesystem>
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

/// What `name` can be, for --help.
inline constexpr const char* kTakeNames =
    "TAKE or TAKE:FROM-TO (.c3d, .csv, .trc, .txt of IEMOCAP, .bnd or a folder of them; frames from 0), or \"builtin\" "
    "or \"builtin:SECONDS\"";

/// A file, a stretch of it ("PATH:FROM-TO"), or the built-in performer for "builtin" or "builtin:SECONDS".
std::unique_ptr<TakeReader> open_take_or_builtin(const std::string& name, const TakeOptions& options);

/// Without the range; "builtin" for the performer.
std::filesystem::path path_of_take(const std::string& name);

/// Prints the take's warnings to stderr.
void print_warnings(const TakeReader& take);

}  // namespace risorius
