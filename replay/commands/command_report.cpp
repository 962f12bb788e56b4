// risorius report: one take on one page.
#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/dataset/take_report.h"
#include "replay/pipeline/offline_pipeline.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

struct ReportArguments {
  std::string take_name, rig, output;
  TakeArguments take;
};

void report(const ReportArguments& arguments) {
  const Rig rig = rig_of_argument(arguments.rig);
  check_outputs({arguments.rig, path_of_take(arguments.take_name)}, {arguments.output});
  const auto take = open_take_or_builtin(arguments.take_name, arguments.take.options());
  print_warnings(*take);
  const std::string name = std::filesystem::path(arguments.take_name).filename().string();
  TakeReport page(rig, take->info().markers, name);
  ProgressLine progress("solving", "frames");
  std::uint64_t frames = 0;
  solve_both_directions(
      *take, {}, rig,
      [&](const SolvedFrame& frame) {
        page.add(frame);
        ++frames;
      },
      [&](std::uint64_t done, std::uint64_t of) { progress.show(done, of); });
  progress.finish(frames);
  page.draw().save_png(arguments.output);
  for (const Slip& slip : page.slip().slips()) {
    fmt::print(stderr, "warning: {} slipped by {:.1f} mm at {:.1f} s; AUs from then on are in doubt\n",
               slip.marker.empty() ? "the head band (all stabilisers)" : "stabiliser " + slip.marker, slip.moved_mm,
               slip.time_s);
  }
  const double off_mm = page.slip().now().neutral_mm;
  fmt::print("{} episodes; {}\nwritten: {}\n", page.episodes().size(),
             std::isnan(off_mm) ? "the face is never at rest long enough to compare it with the neutral"
                                : fmt::format("at rest, the face is {:.2f} mm rms from the neutral", off_mm),
             arguments.output);
}

}  // namespace

void add_report_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("report", "draw a take's AUs, residual, gaps and slips on one page (PNG)");
  auto arguments = std::make_shared<ReportArguments>();
  command->add_option("take", arguments->take_name, kTakeNames)->required();
  command->add_option("--rig", arguments->rig, "rig file, actor folder, or \"builtin\"")->required();
  command->add_option("-o,--output", arguments->output, "PNG to write")->required();
  arguments->take.add_to(*command);
  command->callback([arguments] { report(*arguments); });
}

}  // namespace risorius
