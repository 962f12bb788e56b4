// risorius plot repair: tracks before and after repair, as a picture.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/clean_arguments.h"
#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/picture/repair_picture.h"

namespace risorius {
namespace {

struct PlotCommand {
  CleanArguments clean;
  std::string output;
  bool head_still = false;
};

constexpr std::size_t kChosenMarkers = 4;

void plot_repair(PlotCommand& command) {
  check_outputs({path_of_take(command.clean.take)}, {command.output});
  MarkerSet set;
  CleanedTake cleaned = command.clean.run(set);
  if (cleaned.after.empty()) throw UserError(command.clean.take, "has no frames", "choose another stretch");
  if (command.head_still) hold_head_still(cleaned, set);
  auto markers = command.clean.needed_markers;
  if (markers.empty()) markers = most_repaired(cleaned, set, kChosenMarkers);
  if (markers.empty())
    throw UserError(command.clean.take, "none of its markers is ever measured", "choose another take");
  repair_picture(cleaned.before, cleaned.after, set, markers).save_png(command.output);
  fmt::print("written: {}\n", command.output);
}

}  // namespace

void add_plot_command(CLI::App& app) {
  CLI::App* plot = app.add_subcommand("plot", "pictures of takes");
  plot->require_subcommand(1);
  CLI::App* repair = plot->add_subcommand("repair", "tracks of markers before and after repair, with 90 % bands");
  auto arguments = std::make_shared<PlotCommand>();
  arguments->clean.add_to(*repair);
  repair->add_option("--marker", arguments->clean.needed_markers,
                     "names of markers, one row of the picture each (default: the four that were repaired most)");
  repair->add_flag("--head-still", arguments->head_still, "with the head's motion taken out");
  repair->add_option("-o,--output", arguments->output, "picture to write (.png)")->required();
  repair->callback([arguments] { plot_repair(*arguments); });
}

}  // namespace risorius
