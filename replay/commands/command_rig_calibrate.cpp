// risorius rig calibrate: from a neutral and one recording per AU at its maximum to the actor's rig (seed 003).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <memory>
#include <vector>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_fit_arguments.h"
#include "replay/pipeline/calibration_recording.h"
#include "replay/progress_line.h"
#include "solve/rigs/au_name.h"
#include "solve/rigs/rig_calibrate.h"

namespace risorius {
namespace {

struct CalibrateArguments {
  RigFitArguments fit;
  std::vector<std::string> aus;
  bool keeps_fitted = false;
};

struct NamedTake {
  std::string au, take;
};

NamedTake parse_named_take(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size()) {
    throw UserError("--au " + text, "is not NAME=TAKE", "such as --au AU12L=smile.c3d or --au AU12L=rom.c3d:300-420");
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::vector<CalibrationRecording> read_recordings(const CalibrateArguments& arguments, const Rig& fitted) {
  std::vector<CalibrationRecording> recordings;
  std::map<std::string, std::string> au_of_take;
  ProgressLine progress("reading the recordings", "takes");
  for (const std::string& text : arguments.aus) {
    const auto [au, name] = parse_named_take(text);
    if (const auto [other, is_new] = au_of_take.emplace(name, au); !is_new) {
      throw UserError("--au " + text, fmt::format("{} is given for {} already", name, other->second),
                      "each AU needs a recording, or a stretch of one (TAKE:FROM-TO), of its own");
    }
    const TakeRange range = parse_take_range(name);
    check_outputs({range.path}, {arguments.fit.output});
    if (!parse_au_name(au) && std::ranges::find(fitted.aus, au, &RigAu::name) == fitted.aus.end()) {
      throw UserError(
          "--au " + text, fmt::format("'{}' is no AU", au),
          fmt::format("give AU + number + L, R or nothing, or one of {}", fmt::join(fitted.au_names(), " ")));
    }
    if (std::ranges::find(fitted.aus, au, &RigAu::name) == fitted.aus.end()) {
      fmt::print(stderr, "--au {}: warning: the face has no {}, so neither side nor place of what moves is checked\n",
                 text, au);
    }
    const auto take = open_take_or_builtin(range.path.string(), arguments.fit.take.options());
    print_warnings(*take);
    recordings.push_back(calibration_recording_of(*take, range, fitted, au));
    progress.show(recordings.size(), arguments.aus.size());
  }
  progress.finish(recordings.size());
  return recordings;
}

void print_calibration(const RigCalibration& result) {
  fmt::print("{:<12} {:>6} {:>5}  {:<12} {:>8} {:>8} {:>8} {:>6} {:>6}  {}\n", "AU", "frames", "held", "moves most",
             "peak", "noise", "rest", "left", "match", "most like");
  for (const AuCalibration& au : result.aus) {
    fmt::print("{:<12} {:>6} {:>5}  {:<12} {:>5.1f} mm {:>5.2f} mm {:>5.2f} mm {:>4.0f} % {:>6}  {} ({:.2f})\n", au.au,
               au.frames, au.held_frames, au.peak_marker, au.peak_mm, au.noise_mm, au.rest_mm, 100 * au.left_share,
               std::isnan(au.match) ? "-" : fmt::format("{:.2f}", au.match), au.best_match, au.best_match_cosine);
  }
  fmt::print("{} AUs; condition number of their normalised fields {:.3g}\n", result.aus.size(), result.condition);
  for (const auto& warning : result.warnings) fmt::print(stderr, "warning: {}\n", warning);
}

/// The AUs that were not recorded keep the generic face's fields.
void add_fitted(const Rig& fitted, Rig& rig) {
  for (const RigAu& au : fitted.aus) {
    if (std::ranges::find(rig.aus, au.name, &RigAu::name) == rig.aus.end()) rig.aus.push_back(au);
  }
}

void calibrate(const CalibrateArguments& arguments) {
  const RigFitResult fitted = arguments.fit.fit();
  print_warnings(fitted);
  RigCalibration result = calibrate_rig(fitted.rig, read_recordings(arguments, fitted.rig));
  result.rig.source = fmt::format("calibrated from {} recordings{}; {}", result.aus.size(),
                                  arguments.keeps_fitted ? ", other AUs fitted" : "", fitted.rig.source);
  if (arguments.keeps_fitted) add_fitted(fitted.rig, result.rig);
  save_rig(result.rig, arguments.fit.output);
  print_calibration(result);
  fmt::print("written: {}\n", arguments.fit.output);
}

}  // namespace

void add_rig_calibrate_command(CLI::App& rig) {
  CLI::App* command = rig.add_subcommand("calibrate", "measure an actor's AUs: one recording each, at its maximum");
  auto arguments = std::make_shared<CalibrateArguments>();
  arguments->fit.add_to(*command);
  command
      ->add_option("--au", arguments->aus,
                   "NAME=TAKE or NAME=TAKE:FROM-TO, once per AU: from rest to the AU's maximum, held, and back")
      ->required();
  command->add_flag("--keep-fitted", arguments->keeps_fitted,
                    "keep the generic face's fields for AUs that were not recorded");
  command->callback([arguments] { calibrate(*arguments); });
}

}  // namespace risorius
