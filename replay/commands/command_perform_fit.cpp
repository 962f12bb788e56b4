// risorius perform-fit: from a recorded AU series to the table of dynamics that drives the performer.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/atomic_file.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/performer/dynamics_fit.h"
#include "replay/progress_line.h"
#include "replay/takes/face_series.h"

namespace risorius {
namespace {

struct FitArguments {
  std::string series, output, credit, licence;
  double rate_hz = 0;
  DynamicsFitOptions options;
};

/// What the table makes, with a seed that the fit has not used, beside what was recorded.
void print_result(const PreparedSeries& recorded, const Dynamics& dynamics, std::uint64_t seed) {
  constexpr int kTakes = 10;
  const ActionDistributions real = distributions_of(find_actions(recorded));
  const ActionDistributions made = performed_distributions(
      recorded.names, dynamics, static_cast<double>(recorded.rows.size()) / recorded.rate_hz, kTakes, seed);
  fmt::print("{:<20} {:>9} {:>9}\n", "median, p90", "recorded", "performed");
  const auto row = [](const char* name, const std::vector<double>& a, const std::vector<double>& b) {
    for (const double share : {0.5, 0.9})
      fmt::print("{:<20} {:>9.3f} {:>9.3f}\n", name, quantile_of(a, share), quantile_of(b, share));
  };
  row("peak velocity, 1/s", real.peak_velocity, made.peak_velocity);
  row("duration, s", real.duration_s, made.duration_s);
  row("rest to rest, s", real.rest_to_rest_s, made.rest_to_rest_s);
}

void fit(const FitArguments& arguments) {
  const std::optional<double> given = arguments.rate_hz > 0 ? std::optional(arguments.rate_hz) : std::nullopt;
  const FaceSeries face = load_face_series(arguments.series, {.rate_hz = given});
  for (const auto& warning : face.warnings) fmt::print(stderr, "{}: warning: {}\n", arguments.series, warning);
  if (!face.rate_hz) throw UserError(arguments.series, "an AU CSV does not say its rate", "give --rate");
  if (face.aus.frames.empty()) throw UserError(arguments.series, "has no frames", "give a series with frames");
  const PreparedSeries prepared = prepare_series(face.aus, *face.rate_hz);
  const std::vector<AuAction> actions = find_actions(prepared);
  constexpr std::size_t kLeast = 30;
  if (actions.size() < kLeast)
    throw UserError(arguments.series, fmt::format("only {} actions", actions.size()),
                    fmt::format("a range of motion with at least {} is needed", kLeast));
  ProgressLine progress("fit", "rounds");
  Dynamics dynamics = fit_dynamics(prepared, arguments.options, [&](int round, int of) {
    progress.show(static_cast<std::uint64_t>(round), static_cast<std::uint64_t>(of));
  });
  progress.finish(static_cast<std::uint64_t>(arguments.options.rounds));
  const std::string name = std::filesystem::path(arguments.series).filename().string();
  dynamics.source = name + (arguments.credit.empty() ? "" : ", " + arguments.credit);
  dynamics.licence = arguments.licence;
  dynamics.made_by = fmt::format("risorius perform-fit {} --seed {} --rounds {}", name, arguments.options.seed,
                                 arguments.options.rounds);
  AtomicFile file(arguments.output);
  file.write(dynamics_to_json(dynamics));
  file.commit();
  fmt::print("{}: from {} actions of {} AUs in {:.1f} s\n", arguments.output, actions.size(), prepared.names.size(),
             static_cast<double>(prepared.rows.size()) / prepared.rate_hz);
  print_result(prepared, dynamics, arguments.options.seed + 1);
}

}  // namespace

void add_perform_fit_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("perform-fit", "fit the performer's dynamics to a recorded AU series");
  auto arguments = std::make_shared<FitArguments>();
  command->add_option("series", arguments->series, "Live Link Face CSV or AU CSV of a range of motion")->required();
  command->add_option("-o,--output", arguments->output, "dynamics table to write (JSON)")->required();
  command->add_option("--rate", arguments->rate_hz, "frames per second (default: what the timecodes say)")
      ->check(number_between(1.0, 2000.0));
  command->add_option("--credit", arguments->credit, "who made the recording; goes into the table");
  command->add_option("--licence", arguments->licence, "of the recording; goes into the table");
  command->add_option("--rounds", arguments->options.rounds, "of simulated moments")
      ->check(number_between(1, 1000))
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "same seed, same bytes")
      ->check(whole_number())
      ->capture_default_str();
  command->callback([arguments] { fit(*arguments); });
}

}  // namespace risorius
