#include "replay/commands/rig_fit_arguments.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/commands/face_argument.h"
#include "replay/commands/output_check.h"
#include "replay/pipeline/neutral.h"
#include "solve/faces/landmark_map.h"

namespace risorius {
namespace {

constexpr std::uint64_t kFewFrames = 10;

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

}  // namespace

void RigFitArguments::add_to(CLI::App& command) {
  command.add_option("--face", face, "\"builtin\", or the folder of ICT-FaceKit's OBJ files")->capture_default_str();
  command.add_option("--neutral", neutral, "TAKE or TAKE:FROM-TO, frames from 0 in which the face is at rest")
      ->required();
  command
      .add_option("--landmarks", landmarks,
                  "which marker sits on which landmark: iemocap55, animface41, bu4dfe83, ibug68, or a JSON file")
      ->required();
  command.add_option("-o,--output", output, "rig file to write (JSON)")->required();
  command.add_option("--name", name, "the rig's name (default: from the file name)");
  take.add_to(command);
}

RigFitResult RigFitArguments::fit() const {
  const LandmarkMap map = find_landmark_map(landmarks);
  const TakeRange range = parse_take_range(neutral);
  check_outputs({range.path, landmarks}, {output});
  const auto reader = open_take_or_builtin(range.path.string(), take.options());
  print_warnings(*reader);
  const Neutral positions = neutral_of(*reader, range.first.value_or(0), last_frame_of(*reader, range));
  if (positions.frame_count < kFewFrames) {
    fmt::print(
        stderr,
        "{}: warning: a neutral of {} frame{} carries the noise of single frames into every AU; give {} or more\n",
        neutral, positions.frame_count, positions.frame_count == 1 ? "" : "s", kFewFrames);
  }
  RigFitResult result = fit_rig(face_of_argument(face), positions.marker_names, positions.position_mm, map);
  result.rig.name = name.empty() ? std::filesystem::path(output).stem().string() : name;
  result.rig.source = fmt::format("face {}, neutral {}, {} frames, landmarks {}",
                                  std::filesystem::path(face).lexically_normal().filename().string(),
                                  std::filesystem::path(neutral).filename().string(), positions.frame_count, map.name);
  return result;
}

void print_warnings(const RigFitResult& fit) {
  for (const auto& warning : fit.warnings) fmt::print(stderr, "warning: {}\n", warning);
}

}  // namespace risorius
