// risorius transition: all frames from one expression to another, in one call.
#include "replay/commands/command_transition.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "capture/errors.h"
#include "generate/transition_models.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/takes/au_csv.h"
#include "replay/transitions/pose_argument.h"
#include "replay/transitions/transition_picture.h"

namespace risorius {
namespace {

constexpr double kDecimals = 1e6;  // of what is written: a float tells no more

struct TransitionArguments {
  std::string from, to, output, rig = "builtin";
  std::string model{kTransitionModelNames.front()};
  std::string frames = "120";  ///< or "auto"
  std::int64_t variants = 1;
  double rate_hz = 120, from_rate_hz = 0;  // 0: not given
};

std::string model_names() {
  std::string names;
  for (const std::string_view name : kTransitionModelNames) {
    if (!names.empty()) names += ", ";
    names += name;
  }
  return names;
}

/// "out.csv" of the only variant, else "out-1.csv", "out-2.csv", ...
std::filesystem::path variant_path(const TransitionArguments& arguments, std::int64_t variant) {
  std::filesystem::path path = arguments.output;
  if (arguments.variants > 1)
    path.replace_filename(fmt::format("{}-{}{}", path.stem().string(), variant + 1, path.extension().string()));
  return path;
}

void write_course(const std::filesystem::path& path, const TransitionEnds& ends, const AuMatrix& course,
                  double rate_hz) {
  AuCsvWriter writer(path, ends.names);
  AuFrame frame;
  frame.count = static_cast<std::uint32_t>(ends.names.size());
  frame.state.fill(AuState::kObserved);
  for (Eigen::Index row = -1; row < course.rows(); ++row) {
    frame.header.sequence = static_cast<std::uint64_t>(row + 1);
    frame.header.capture_time_ns = static_cast<std::int64_t>(static_cast<double>(row + 1) / rate_hz * 1e9);
    for (Eigen::Index au = 0; au < course.cols(); ++au) {
      const float value = row < 0 ? ends.past(ends.past.rows() - 1, au) : course(row, au);
      frame.intensity[static_cast<std::size_t>(au)] = std::round(value * kDecimals) / kDecimals;
    }
    writer.write(frame);
  }
  writer.finish();
}

Eigen::Index frames_of(const TransitionArguments& arguments, TransitionModel& model, const TransitionRequest& request) {
  if (const auto frames = number_unless_auto(arguments.frames)) return std::llround(*frames);
  const Eigen::Index expected = model.expected_frames(request);
  if (expected == 0) {
    throw UserError("--frames", "auto: " + arguments.model + " cannot tell how long a face takes",
                    "give a number, or leave --model out");
  }
  fmt::print("{} frames, {:.2f} s: as long as a face is expected to take\n", expected,
             static_cast<double>(expected) / arguments.rate_hz);
  return expected;
}

void generate(const TransitionArguments& arguments) {
  std::filesystem::path picture = arguments.output;
  picture.replace_extension(".png");
  std::vector<std::filesystem::path> outputs{picture};
  for (std::int64_t variant = 0; variant < arguments.variants; ++variant)
    outputs.push_back(variant_path(arguments, variant));
  check_output_name(arguments.output, "an AU series", {".csv"});
  check_outputs({file_of_end(arguments.from), file_of_end(arguments.to)}, outputs);
  const TransitionEnds ends = transition_ends(
      arguments.from, arguments.to, rig_of_argument(arguments.rig).au_names(),
      {.rate_hz = arguments.rate_hz,
       .from_rate_hz = arguments.from_rate_hz > 0 ? std::optional(arguments.from_rate_hz) : std::nullopt});
  if (ends.names.size() > kMaxAus)
    throw UserError(arguments.from, fmt::format("{} AUs", ends.names.size()), fmt::format("at most {}", kMaxAus));
  for (const std::string& note : ends.notes) fmt::print("note: {}\n", note);
  const std::unique_ptr<TransitionModel> model = make_transition_model(arguments.model, ends.names);
  if (model == nullptr)
    throw UserError("--model", "\"" + arguments.model + "\" is not known", "there are: " + model_names());

  TransitionRequest request{.past = ends.past, .target = ends.target, .rate_hz = arguments.rate_hz};
  request.frames = frames_of(arguments, *model, request);
  std::vector<TransitionCourse> courses;
  for (std::int64_t variant = 0; variant < arguments.variants; ++variant) {
    request.repetition = static_cast<std::uint64_t>(variant);
    TransitionCourse course{
        arguments.variants > 1 ? fmt::format("variant {}", variant + 1) : arguments.model, {}, false};
    model->generate(request, course.rows);
    if (variant > 0 && course.rows == courses.front().rows) {
      throw UserError("--variants", arguments.model + " makes the same course every time",
                      "leave it out, or choose a model that varies");
    }
    courses.push_back(std::move(course));
  }
  for (std::int64_t variant = 0; variant < arguments.variants; ++variant) {
    const auto path = variant_path(arguments, variant);
    write_course(path, ends, courses[static_cast<std::size_t>(variant)].rows, arguments.rate_hz);
    fmt::print("written: {}\n", path.string());
  }
  const auto name_of = [](const std::string& end) { return std::filesystem::path(end).filename().string(); };
  const std::string title =
      fmt::format("{} to {}: {} frame{} at {:g} Hz, {}", name_of(arguments.from), name_of(arguments.to), request.frames,
                  request.frames == 1 ? "" : "s", arguments.rate_hz, arguments.model);
  transition_picture(title, ends.names, ends.past, courses, arguments.rate_hz).save_png(picture);
  fmt::print("written: {}\n", picture.string());
}

}  // namespace

void add_transition_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("transition", "all frames from one expression to another");
  auto arguments = std::make_shared<TransitionArguments>();
  command->add_option("--from", arguments->from, "expression (happy, sad:2), or AU series (its last frame; FILE:FRAME)")
      ->required();
  command->add_option("--to", arguments->to, "expression, or AU series (its first frame; FILE:FRAME)")->required();
  command
      ->add_option("--frames", arguments->frames,
                   "that are made; the last one is the target. \"auto\": as many as a face takes")
      ->check(count_or_auto(100000))
      ->capture_default_str();
  command->add_option("--rate", arguments->rate_hz, "frames per second")
      ->check(number_between(1, 2000))
      ->capture_default_str();
  command
      ->add_option("--from-rate", arguments->from_rate_hz,
                   "frames per second of the start's series (default: what its timecodes say, else --rate)")
      ->check(number_between(1, 2000));
  command->add_option("--variants", arguments->variants, "varied repetitions, one file each")
      ->check(number_between(1, 1000))
      ->capture_default_str();
  command->add_option("--model", arguments->model, model_names())->capture_default_str();
  command->add_option("--rig", arguments->rig, "whose AUs, where neither end is a series: \"builtin\" or a rig")
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "AU series to write (.csv); a picture (.png) goes beside it")
      ->required();
  command->callback([arguments] { generate(*arguments); });
}

}  // namespace risorius
