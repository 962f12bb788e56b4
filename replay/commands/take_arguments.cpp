#include "replay/commands/take_arguments.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/commands/number_check.h"
#include "replay/performer/performer.h"
#include "replay/takes/range_take.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

constexpr std::string_view kBuiltin = "builtin";
constexpr double kLongestSeconds = 86400;

/// The seconds of "builtin:SECONDS".
double seconds_of(const std::string& name) {
  if (name == kBuiltin) return PerformerOptions{}.seconds;
  double seconds = 0;
  const char* begin = name.data() + kBuiltin.size() + 1;
  const char* end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(begin, end, seconds);
  if (error != std::errc() || stop != end || !(seconds > 0 && seconds <= kLongestSeconds)) {
    throw UserError(name, "does not say how many seconds the built-in performer shall play",
                    "write builtin:20, more than 0 and at most 86400");
  }
  return seconds;
}

}  // namespace

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

std::unique_ptr<TakeReader> open_take_or_builtin(const std::string& name, const TakeOptions& options) {
  if (name != kBuiltin && !name.starts_with("builtin:")) {
    const TakeRange range = parse_take_range(name);
    auto take = open_take(range.path, options);
    if (!range.first) return take;
    return std::make_unique<RangeTake>(std::move(take), *range.first, *range.last);
  }
  PerformerOptions performance{.seconds = seconds_of(name)};
  if (options.rate_hz) performance.rate_hz = *options.rate_hz;
  return std::make_unique<PerformerTake>(builtin_rig(), performance);
}

std::filesystem::path path_of_take(const std::string& name) {
  if (name == kBuiltin || name.starts_with("builtin:")) return kBuiltin;
  return parse_take_range(name).path;
}

void print_warnings(const TakeReader& take) {
  for (const auto& warning : take.info().warnings)
    fmt::print(stderr, "{}: warning: {}\n", take.info().path.string(), warning);
}

}  // namespace risorius
