// risorius clean: a take repaired, as a take.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "replay/commands/clean_arguments.h"
#include "replay/commands/commands.h"
#include "replay/commands/output_check.h"
#include "replay/commands/take_output.h"

namespace risorius {
namespace {

struct CleanCommand {
  CleanArguments clean;
  std::string output;
};

void clean(CleanCommand& command) {
  check_outputs({path_of_take(command.clean.take)}, {command.output});
  check_take_output(command.output);
  MarkerSet set;
  const CleanedTake cleaned = command.clean.run(set);
  const auto output = make_take_writer(command.output, set);
  for (const MarkerFrame& frame : cleaned.after) output->write(frame);
  output->finish();
  std::string reasons;
  for (std::size_t r = 1; r < cleaned.rejected.size(); ++r) {
    if (cleaned.rejected[r] == 0) continue;
    reasons +=
        fmt::format("{}{} {}", reasons.empty() ? "" : ", ", name_of(static_cast<RejectReason>(r)), cleaned.rejected[r]);
  }
  fmt::print("{}: {} frames; samples measured {}, missing {}, rejected ({}), filled {}, left missing {}\n",
             command.output, cleaned.after.size(), cleaned.measured, cleaned.missing,
             reasons.empty() ? "none" : reasons, cleaned.filled, cleaned.left_missing);
}

}  // namespace

void add_clean_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("clean", "repair a take: false tracks out, gaps filled, deviations stated");
  auto arguments = std::make_shared<CleanCommand>();
  arguments->clean.add_to(*command);
  command->add_option("-o,--output", arguments->output, "take to write (.c3d, .csv)")->required();
  command->callback([arguments] { clean(*arguments); });
}

}  // namespace risorius
