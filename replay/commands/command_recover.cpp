// risorius recover: a whole file of a torn one.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "replay/commands/output_check.h"
#include "replay/commands/session_commands.h"
#include "replay/progress_line.h"
#include "replay/session/session_recover.h"

namespace risorius {
namespace {

void recover(const std::string& input, const std::string& chosen) {
  std::filesystem::path output = chosen;
  if (chosen.empty()) output = std::filesystem::path(input).replace_extension(".recovered.mcap");
  check_outputs({input}, {output});
  ProgressLine progress("recovering", "bytes");
  const RecoveredSession session =
      recover_session(input, output, [&progress](std::uint64_t done, std::uint64_t of) { progress.show(done, of); });
  progress.finish(std::filesystem::file_size(input));
  fmt::print("{} messages", session.messages);
  if (session.messages > 0) fmt::print(", {} to {}", utc_text(session.first_ns), utc_text(session.last_ns));
  fmt::print("\n");
  const auto missing = missing_times(session);
  for (const std::string& line : missing) fmt::print("missing: {}\n", line);
  if (missing.empty()) fmt::print("nothing is missing\n");
  fmt::print("written: {}\n", output.string());
}

}  // namespace

void add_recover_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("recover", "make a whole file of a torn session, and say which times are missing");
  auto input = std::make_shared<std::string>(), output = std::make_shared<std::string>();
  command->add_option("file", *input, "MCAP file")->required();
  command->add_option("-o,--output", *output, "file to make; default: NAME.recovered.mcap beside it");
  command->callback([input, output] { recover(*input, *output); });
}

}  // namespace risorius
