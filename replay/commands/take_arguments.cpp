#include "replay/commands/take_arguments.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/commands/number_check.h"

namespace risorius {
void TakeArguments::add_to(CLI::App& command) {
  command.add_option("--units", units, "of the take's numbers: mm, cm, m (default: what the file says, else mm)");
  command.add_option("--axes", axes,
                     "directions of the take's x y z: three of L R U D F B (default LUF: x to the subject's left, y "
                     "up, z out of the face)");
  command.add_option("--rate", rate_hz, "frames per second (default: what the file says)")
      ->check(number_between(0.01, 1e5));
}

TakeOptions TakeArguments::options() const {
  TakeOptions options;
  if (!units.empty() && !(options.mm_per_unit = parse_unit(units))) {
    throw UserError("--units", "\"" + units + "\" is not a known unit", "give mm, cm or m");
  }
  if (!axes.empty() && !(options.axes = Axes::parse(axes))) {
    throw UserError("--axes", "\"" + axes + "\" does not name three different directions",
                    "give one of L R, one of U D and one of F B in the order of x y z, such as LUF");
  }
  if (!std::isfinite(rate_hz)) throw UserError("--rate", "is not a number", "give frames per second");
  if (rate_hz > 0) options.rate_hz = rate_hz;
  return options;
}

void print_warnings(const TakeReader& take) {
  for (const auto& warning : take.info().warnings)
    fmt::print(stderr, "{}: warning: {}\n", take.info().path.string(), warning);
}

}  // namespace risorius
