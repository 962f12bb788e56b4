// risorius perform: the synthetic performer as a take, with its truth beside it.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/take_output.h"
#include "replay/performer/performer.h"
#include "replay/performer/truth_files.h"
#include "replay/progress_line.h"
#include "replay/takes/face_series.h"

namespace risorius {
namespace {

constexpr double kUsualOcclusions = 0.03, kUsualRegionsPerMinute = 2, kUsualFalseTracks = 0.005;

struct PerformArguments {
  std::string rig = "builtin", script = "expressions", au, arkit_table, output, truth, true_rig;
  double seconds = 0, au_rate_hz = 0;
  bool occlude = false, outliers = false, perturb = false, pure = false;
  PerformerOptions options;
};

struct RecordedAus {
  AuSeries series;
  double rate_hz;
};

/// An AU series, or shapes through the table.
RecordedAus load_aus(const PerformArguments& arguments, const Rig& rig) {
  const std::optional<double> given = arguments.au_rate_hz > 0 ? std::optional(arguments.au_rate_hz) : std::nullopt;
  const std::vector<std::string> names = rig.au_names();
  const bool split_jaw = std::find(names.begin(), names.end(), "AU26") != names.end();
  const ArkitTable given_table = arguments.arkit_table.empty() ? ArkitTable{} : load_arkit_table(arguments.arkit_table);
  FaceSeries face = load_face_series(arguments.au, {.rate_hz = given,
                                                    .jaw = split_jaw ? JawColumns::kSplit : JawColumns::kWhole,
                                                    .table = arguments.arkit_table.empty() ? nullptr : &given_table});
  for (const auto& warning : face.warnings) fmt::print(stderr, "{}: warning: {}\n", arguments.au, warning);
  if (!face.rate_hz) {
    fmt::print(stderr, "{}: no rate in the file: {:g} Hz assumed (--au-rate)\n", arguments.au,
               arguments.options.rate_hz);
  }
  return {std::move(face.aus), face.rate_hz.value_or(arguments.options.rate_hz)};
}

/// Said once: what the rig cannot play, and what nobody drives.
void report_channels(const std::vector<std::string>& lacking, const std::vector<std::string>& still,
                     const std::string& rig) {
  if (!lacking.empty())
    fmt::print(stderr, "masked, because the rig {} has no such column: {}\n", rig, fmt::join(lacking, " "));
  if (!still.empty()) fmt::print(stderr, "at rest, because the series does not have them: {}\n", fmt::join(still, " "));
}

Performance make_performance(const PerformArguments& arguments) {
  const Rig rig = rig_of_argument(arguments.rig);
  PerformerOptions options = arguments.options;
  options.seconds = arguments.seconds;
  options.occlusion_share = arguments.occlude ? kUsualOcclusions : 0;
  options.regions_per_minute = arguments.occlude ? kUsualRegionsPerMinute : 0;
  options.false_track_share = arguments.outliers ? kUsualFalseTracks : 0;
  options.co_activation = !arguments.pure;
  if (arguments.perturb) options.perturb = PerturbOptions::like_people();
  if (!arguments.au.empty()) {
    const RecordedAus recorded = load_aus(arguments, rig);
    if (recorded.series.frames.empty()) throw UserError(arguments.au, "has no frames", "give a series with frames");
    AuTimeline timeline(recorded.series, recorded.rate_hz, rig.au_names());
    if (timeline.masked().size() == rig.au_count()) {
      throw UserError(arguments.au, fmt::format("none of its columns is an AU of the rig {}", rig.name),
                      "name the columns as the rig does, such as AU12L");
    }
    report_channels(timeline.unused(), timeline.masked(), rig.name);
    return Performance(rig, std::move(timeline), options);
  }
  const auto kind = parse_script_kind(arguments.script);
  if (!kind)
    throw UserError("--script", "\"" + arguments.script + "\" is no script",
                    "give expressions, speech, rom, idle or mixed");
  options.script = *kind;
  const bool ends_by_itself = *kind == ScriptKind::kExpressions || *kind == ScriptKind::kRom;
  if (options.seconds == 0 && !ends_by_itself) options.seconds = PerformerOptions{}.seconds;
  Performance performance(rig, options);
  report_channels(performance.script()->masked(), {}, rig.name);
  return performance;
}

void check_files(const PerformArguments& arguments) {
  std::vector<std::filesystem::path> outputs{arguments.output, arguments.true_rig};
  if (!arguments.truth.empty()) {
    const auto truth = TruthWriter::paths_for(arguments.truth);
    outputs.insert(outputs.end(), truth.begin(), truth.end());
  }
  check_outputs({arguments.rig, arguments.au, arguments.arkit_table}, outputs);
  check_take_output(arguments.output);
}

void perform(const PerformArguments& arguments) {
  check_files(arguments);
  Performance performance = make_performance(arguments);
  const auto take = make_take_writer(arguments.output, performance.marker_set());
  std::unique_ptr<TruthWriter> truth_files;
  if (!arguments.truth.empty())
    truth_files = std::make_unique<TruthWriter>(arguments.truth, performance.rig().au_names());
  const auto observed = std::make_unique<MarkerFrame>(), clean = std::make_unique<MarkerFrame>();
  const auto truth = std::make_unique<AuFrame>();
  ProgressLine progress("perform", "frames");
  std::uint64_t done = 0;
  while (performance.next(*observed, *truth, *clean)) {
    take->write(*observed);
    if (truth_files) truth_files->write(*truth, performance.causes());
    progress.show(++done, performance.frame_count());
  }
  progress.finish(done);
  take->finish();
  if (truth_files) truth_files->finish(performance.script() ? performance.script()->cues() : std::vector<ScriptCue>{});
  if (!arguments.true_rig.empty()) save_rig(performance.true_rig(), arguments.true_rig);
  fmt::print("{}: {} frames, {:.2f} s at {:g} Hz, {} markers\n", arguments.output, done,
             static_cast<double>(done) / performance.options().rate_hz, performance.options().rate_hz,
             performance.rig().marker_count());
  if (!truth_files) return;
  for (const auto& path : truth_files->paths()) fmt::print("{}\n", path.string());
}

}  // namespace

void add_perform_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("perform", "a synthetic performer on a rig, with exact ground truth");
  auto arguments = std::make_shared<PerformArguments>();
  PerformerOptions& options = arguments->options;
  command->add_option("--rig", arguments->rig, "rig file, or \"builtin\"")->capture_default_str();
  auto* script = command->add_option("--script", arguments->script, "expressions, speech, rom, idle or mixed");
  script->capture_default_str();
  command->add_option("--au", arguments->au, "AU CSV or Live Link Face CSV that drives the face")->excludes(script);
  command
      ->add_option("--au-rate", arguments->au_rate_hz,
                   "frames per second of --au (default: what its timecodes say; of an AU CSV, --rate)")
      ->check(number_between(1.0, 2000.0));
  command->add_option("--arkit-table", arguments->arkit_table, "ARKit table to use (default: the one built in)");
  command
      ->add_option("--seconds", arguments->seconds, "length (default: the whole of --au, expressions or rom; else 60)")
      ->check(number_between(0.01, 86400.0));
  command->add_option("--rate", options.rate_hz, "frames per second")
      ->check(number_between(1.0, 2000.0))
      ->capture_default_str();
  command->add_option("--noise", options.noise_mm, "white noise, mm per axis")
      ->check(number_between(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--coloured-noise", options.coloured_noise_mm, "noise that lasts about 0.25 s, mm per axis")
      ->check(number_between(0.0, 10.0))
      ->capture_default_str();
  command->add_flag("--occlude", arguments->occlude, "3 % occlusions, and two occluded regions a minute");
  command->add_flag("--outliers", arguments->outliers, "0.5 % jumps, ghosts and swaps");
  command->add_flag("--perturb", arguments->perturb,
                    "another person than the rig: identity, basis, marker places, sliding skin");
  command->add_flag("--pure", arguments->pure, "rom without co-activation: each AU really alone");
  command->add_option("--amplitude", options.amplitude, "of rom, times the peaks of the dynamics table")
      ->check(number_between(0.1, 4.0))
      ->capture_default_str();
  command->add_option("--head", options.head_motion, "head motion, 0 to 3")->check(number_between(0.0, 3.0));
  command->add_option("--micro-motion", options.micro_motion, "micro-motion and drift of the rest, 0 to 3")
      ->check(number_between(0.0, 3.0));
  command->add_option("--seed", options.seed, "same seed, same bytes")->check(whole_number())->capture_default_str();
  command->add_option("-o,--output", arguments->output, "take to write (.c3d, .csv)")->required();
  command->add_option("--truth", arguments->truth,
                      "AU CSV to write; NAME.pose.csv, NAME.markers.csv and NAME.cues.csv come beside it");
  command->add_option("--true-rig", arguments->true_rig, "rig file to write: the face that the markers really sit on");
  command->callback([arguments] { perform(*arguments); });
}

}  // namespace risorius
