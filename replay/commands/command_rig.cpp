// risorius rig fit: from a generic face and an actor's neutral to the actor's rig.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/face_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/pipeline/neutral.h"
#include "solve/faces/landmark_map.h"
#include "solve/faces/rig_fit.h"

namespace risorius {
namespace {

struct FitArguments {
  std::string face = "builtin", neutral, landmarks, output, name;
  TakeArguments take;
};

/// Without a range the whole take is the neutral.
std::uint64_t last_frame_of(TakeReader& take, const TakeRange& range) {
  if (range.last) return *range.last;
  if (take.info().frame_count) return *take.info().frame_count - 1;
  MarkerFrame frame;
  std::uint64_t count = 0;
  while (take.next(frame)) ++count;
  take.rewind();
  if (count == 0) throw UserError(range.path.string(), "has no frames", "give a take with a neutral face");
  return count - 1;
}

void print_fit(const RigFitResult& fit) {
  fmt::print("{:<20} {:>10} {:>11}\n", "marker", "off mesh", "stabiliser");
  for (std::size_t m = 0; m < fit.rig.marker_count(); ++m) {
    const double weight = fit.rig.stabiliser_weight[static_cast<Eigen::Index>(m)];
    fmt::print("{:<20} {:>7.2f} mm {:>11}\n", fit.rig.marker_names[m], fit.rig.fit_distance_mm[m],
               weight > 0 ? fmt::format("{:g}", weight) : "");
  }
  const double largest = *std::ranges::max_element(fit.rig.fit_distance_mm);
  fmt::print(
      "scale {:.3f}; markers off the mesh: median {:.2f} mm, largest {:.2f} mm; landmarks: rms {:.2f} mm, largest "
      "{:.2f} mm\n",
      fit.scale, fit.median_distance_mm, largest, fit.landmark_rms_mm, fit.largest_landmark_residual_mm);
  std::string aus;
  for (const auto& au : fit.rig.aus) aus += " " + au.name;
  fmt::print("{} AUs:{}\n", fit.rig.au_count(), aus);
  if (!fit.dropped_aus.empty()) fmt::print("not seen by any marker, left out: {}\n", fmt::join(fit.dropped_aus, " "));
  if (!fit.left_out_markers.empty())
    fmt::print("never seen in the neutral, left out: {}\n", fmt::join(fit.left_out_markers, " "));
  for (const auto& warning : fit.warnings) fmt::print(stderr, "warning: {}\n", warning);
}

void fit(const FitArguments& arguments) {
  const LandmarkMap map = find_landmark_map(arguments.landmarks);
  const TakeRange range = parse_take_range(arguments.neutral);
  const auto take = open_take_or_builtin(range.path.string(), arguments.take.options());
  print_warnings(*take);
  const Neutral neutral = neutral_of(*take, range.first.value_or(0), last_frame_of(*take, range));
  const FaceModel face = face_of_argument(arguments.face);
  RigFitResult result = fit_rig(face, neutral.marker_names, neutral.position_mm, map);
  const std::string face_name = std::filesystem::path(arguments.face).lexically_normal().filename().string();
  result.rig.name = arguments.name.empty() ? std::filesystem::path(arguments.output).stem().string() : arguments.name;
  result.rig.source =
      fmt::format("face {}, neutral {}, {} frames, landmarks {}", face_name,
                  std::filesystem::path(arguments.neutral).filename().string(), neutral.frame_count, map.name);
  save_rig(result.rig, arguments.output);
  print_fit(result);
  fmt::print("written: {}\n", arguments.output);
}

}  // namespace

void add_rig_command(CLI::App& app) {
  CLI::App* rig = app.add_subcommand("rig", "make rigs: an actor's neutral markers and their displacement per AU");
  rig->require_subcommand(1);
  CLI::App* command = rig->add_subcommand("fit", "fit a generic face to an actor's neutral");
  auto arguments = std::make_shared<FitArguments>();
  command->add_option("--face", arguments->face, "\"builtin\", or the folder of ICT-FaceKit's OBJ files")
      ->capture_default_str();
  command
      ->add_option("--neutral", arguments->neutral, "TAKE or TAKE:FROM-TO, frames from 0 in which the face is at rest")
      ->required();
  command
      ->add_option("--landmarks", arguments->landmarks,
                   "which marker sits on which landmark: iemocap55, animface41, bu4dfe83, ibug68, or a JSON file")
      ->required();
  command->add_option("-o,--output", arguments->output, "rig file to write (JSON)")->required();
  command->add_option("--name", arguments->name, "the rig's name (default: from the file name)");
  arguments->take.add_to(*command);
  command->callback([arguments] { fit(*arguments); });
  add_rig_show_command(*rig);
}

}  // namespace risorius
