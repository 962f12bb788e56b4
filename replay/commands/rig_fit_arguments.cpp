#include "replay/commands/rig_fit_arguments.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/utf8.h"
#include "replay/commands/face_argument.h"
#include "replay/commands/output_check.h"
#include "solve/faces/landmark_map.h"

namespace risorius {
namespace {

constexpr std::uint64_t kFewFrames = 10;

}  // namespace

void RigFitArguments::add_to(CLI::App& command) {
  command.add_option("--face", face, "\"builtin\", or the folder of ICT-FaceKit's OBJ files")->capture_default_str();
  command
      .add_option("--neutral", neutral,
                  "TAKE:FROM-TO, frames from 0 in which the face is at rest; TAKE: all of it; TAKE:auto: found in it")
      ->required();
  command
      .add_option("--landmarks", landmarks,
                  "which marker sits on which landmark: iemocap55, animface41, bu4dfe83, ibug68, or a JSON file")
      ->required();
  command.add_option("-o,--output", output, "rig file to write (JSON)")->required();
  command.add_flag("--generic", is_generic, "turn and scale the face only; do not bend it to the actor");
  command.add_option("--name", name, "the rig's name (default: from the file name)");
  take.add_to(command);
}

RigFitResult RigFitArguments::fit() const {
  const LandmarkMap map = find_landmark_map(landmarks);
  const NeutralPlace place = parse_neutral_place(neutral);
  if (!is_clean_utf8(name)) {
    throw UserError("--name", shown(name) + " has characters that no name has",
                    "give UTF-8 without control characters");
  }
  check_outputs({place.range.path, landmarks}, {output});
  const auto reader = open_take_or_builtin(place.range.path.string(), take.options());
  print_warnings(*reader);
  const ChosenNeutral chosen = read_neutral(*reader, place);
  const Neutral& positions = chosen.neutral;
  if (place.is_auto)
    fmt::print("neutral: {} (look at it: risorius neutral {})\n", chosen.place, place.range.path.string());
  print_warnings(chosen, place, neutral);
  RigFitOptions options;
  options.with_identity = !is_generic;
  RigFitResult result = fit_rig(face_of_argument(face), positions.marker_names, positions.position_mm, map, options);
  result.rig.name = name.empty() ? std::filesystem::path(output).stem().string() : name;
  result.rig.source =
      fmt::format("face {}{}, neutral {}, {} frames, landmarks {}",
                  std::filesystem::path(face).lexically_normal().filename().string(),
                  is_generic ? " (not bent)" : fmt::format(" bent by {:.2f} mm rms", result.identity_rms_mm),
                  std::filesystem::path(chosen.place).filename().string(), positions.frame_count, map.name);
  return result;
}

void print_warnings(const ChosenNeutral& chosen, const NeutralPlace& place, const std::string& given) {
  const Neutral& neutral = chosen.neutral;
  if (neutral.frame_count < kFewFrames) {
    fmt::print(
        stderr,
        "{}: warning: a neutral of {} frame{} carries the noise of single frames into every AU; give {} or more\n",
        given, neutral.frame_count, neutral.frame_count == 1 ? "" : "s", kFewFrames);
  }
  if (neutral.motion_rms_mm > kDoubtedMotionMm) {
    fmt::print(stderr,
               "{}: warning: the face moves by {:.2f} mm rms in this neutral (at rest: below 0.5); risorius neutral {} "
               "shows stiller stretches\n",
               chosen.place, neutral.motion_rms_mm, place.range.path.string());
  }
}

void print_warnings(const RigFitResult& fit) {
  for (const auto& warning : fit.warnings) fmt::print(stderr, "warning: {}\n", warning);
}

}  // namespace risorius
