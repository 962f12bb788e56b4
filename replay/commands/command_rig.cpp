// risorius rig fit: from a generic face and an actor's neutral to the actor's rig.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "replay/commands/commands.h"
#include "replay/commands/rig_fit_arguments.h"

namespace risorius {
namespace {

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
  if (fit.identity_rms_mm > 0) {
    fmt::print("the face was bent to the actor by {:.2f} mm rms; before, the markers were {:.2f} mm off (median)\n",
               fit.identity_rms_mm, fit.generic_median_distance_mm);
  }
  std::string aus;
  for (const auto& au : fit.rig.aus) aus += " " + au.name;
  fmt::print("{} AUs:{}\n", fit.rig.au_count(), aus);
  if (!fit.dropped_aus.empty()) fmt::print("not seen by any marker, left out: {}\n", fmt::join(fit.dropped_aus, " "));
  if (!fit.left_out_markers.empty()) fmt::print("markers left out: {}\n", fmt::join(fit.left_out_markers, " "));
  print_warnings(fit);
}

void fit(const RigFitArguments& arguments) {
  const RigFitResult result = arguments.fit();
  save_rig(result.rig, arguments.output);
  print_fit(result);
  fmt::print("written: {}\n", arguments.output);
}

}  // namespace

void add_rig_command(CLI::App& app) {
  CLI::App* rig = app.add_subcommand("rig", "make rigs: an actor's neutral markers and their displacement per AU");
  rig->require_subcommand(1);
  CLI::App* command = rig->add_subcommand("fit", "fit a generic face to an actor's neutral");
  auto arguments = std::make_shared<RigFitArguments>();
  arguments->add_to(*command);
  command->callback([arguments] { fit(*arguments); });
  add_rig_calibrate_command(*rig);
  add_rig_refine_command(*rig);
  add_rig_check_command(*rig);
  add_rig_show_command(*rig);
}

}  // namespace risorius
