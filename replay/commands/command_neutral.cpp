// risorius neutral: where in a take the face may be at rest.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/commands/take_arguments.h"
#include "replay/picture/canvas.h"
#include "replay/pipeline/neutral_candidates.h"
#include "replay/pipeline/offline_pipeline.h"

namespace risorius {
namespace {

struct NeutralArguments {
  std::string take_name, output;
  TakeArguments take;
};

constexpr Colour kInk{0.15, 0.15, 0.18}, kDot{0.0, 0.45, 0.70}, kOther{0.84, 0.37, 0.0, 0.45};
constexpr int kPanel = 320, kHead = 46;

/// `begin`: the frame of the whole take that the first of `frames` is. The middle frame of each candidate from the
/// front; the best one's dots behind the others.
void draw(const std::vector<MarkerFrame>& frames, std::uint64_t begin, const std::vector<NeutralCandidate>& found,
          const std::string& title, const std::filesystem::path& path) {
  Canvas canvas(kPanel * static_cast<int>(found.size()), kPanel + kHead);
  canvas.text({10, 18}, title, 14, kInk);
  const auto draw_face = [&](std::size_t panel, const NeutralCandidate& candidate, Colour colour, double radius) {
    const MarkerFrame& frame = frames[(candidate.first + candidate.last) / 2];
    double x = 0, y = 0, count = 0, reach = 1;
    for (std::size_t m = 0; m < frame.count; ++m) {
      if (frame.state[m] != MarkerState::kMeasured) continue;
      x += frame.position_mm[m].x, y += frame.position_mm[m].y, ++count;
    }
    x /= count, y /= count;
    for (std::size_t m = 0; m < frame.count; ++m) {
      if (frame.state[m] != MarkerState::kMeasured) continue;
      reach = std::max({reach, std::abs(frame.position_mm[m].x - x), std::abs(frame.position_mm[m].y - y)});
    }
    const double scale = 0.45 * kPanel / reach, left = kPanel * (static_cast<double>(panel) + 0.5);
    for (std::size_t m = 0; m < frame.count; ++m) {
      if (frame.state[m] != MarkerState::kMeasured) continue;
      canvas.fill_circle(
          {left + scale * (frame.position_mm[m].x - x), kHead + 0.5 * kPanel - scale * (frame.position_mm[m].y - y)},
          radius, colour);
    }
  };
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (k > 0) draw_face(k, found.front(), kOther, 5);
    draw_face(k, found[k], kDot, 3);
    canvas.text({kPanel * static_cast<double>(k) + 10, 38},
                fmt::format("{}-{}  score {:.2f}", begin + found[k].first, begin + found[k].last, found[k].score), 12,
                kInk);
  }
  canvas.save_png(path);
}

void find(const NeutralArguments& arguments) {
  check_outputs({path_of_take(arguments.take_name)}, {arguments.output});
  const auto take = open_take_or_builtin(arguments.take_name, arguments.take.options());
  print_warnings(*take);
  const std::vector<MarkerFrame> frames = read_despiked(*take, {});
  const auto found = neutral_candidates(frames);
  const bool is_builtin = path_of_take(arguments.take_name) == "builtin";
  const std::uint64_t begin = is_builtin ? 0 : parse_take_range(arguments.take_name).first.value_or(0);
  const std::string name = is_builtin ? arguments.take_name : path_of_take(arguments.take_name).string();
  if (found.empty()) {
    throw UserError(arguments.take_name, "no stretch in which the face may be at rest was found",
                    "are most markers visible for half a second anywhere?");
  }
  fmt::print("{:>15} {:>8} {:>9} {:>10} {:>9} {:>6}\n", "frames", "seconds", "motion", "asymmetry", "of time", "score");
  for (const NeutralCandidate& candidate : found) {
    fmt::print("{:>15} {:>8.2f} {:>6.2f} mm {:>7.2f} mm {:>7.0f} % {:>6.2f}\n",
               fmt::format("{}-{}", begin + candidate.first, begin + candidate.last), candidate.seconds,
               candidate.motion_mm, candidate.asymmetry_mm, 100 * candidate.frequency, candidate.score);
  }
  fmt::print("look at them; then: risorius rig fit --neutral {}:{}-{} ... (or --neutral {}:auto, the first of them)\n",
             name, begin + found.front().first, begin + found.front().last, arguments.take_name);
  if (arguments.output.empty()) return;
  draw(frames, begin, found, "Stretches that may be neutral (orange: the first of them, for comparison)",
       arguments.output);
  fmt::print("written: {}\n", arguments.output);
}

}  // namespace

void add_neutral_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("neutral", "find stretches of a take in which the face is at rest");
  auto arguments = std::make_shared<NeutralArguments>();
  command->add_option("take", arguments->take_name, kTakeNames)->required();
  command->add_option("-o,--output", arguments->output, "a picture (PNG) of them");
  arguments->take.add_to(*command);
  command->callback([arguments] { find(*arguments); });
}

}  // namespace risorius
