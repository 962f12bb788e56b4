#include "replay/commands/take_argument.h"

#include <charconv>
#include <string_view>

#include "capture/errors.h"
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

}  // namespace risorius
