// risorius verify: a session solved again, and compared with what was recorded.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/session_commands.h"
#include "replay/progress_line.h"
#include "replay/session/session_verify.h"

namespace risorius {
namespace {

void verify(const std::string& path) {
  SessionVerdict verdict;
  {
    ProgressLine progress("solving", "bytes");
    verdict = verify_session(path, [&progress](std::uint64_t done, std::uint64_t of) { progress.show(done, of); });
  }
  for (const std::string& note : verdict.notes) fmt::print("note: {}\n", note);
  fmt::print("{:<28} {:>8} {:>10} {:>13} {:>11}\n", "topic", "equal", "different", "not recorded", "not solved");
  for (const VerifiedTopic& topic : verdict.topics) {
    fmt::print("{:<28} {:>8} {:>10} {:>13} {:>11}\n", shown(topic.topic), topic.equal, topic.different,
               topic.not_recorded, topic.not_solved);
    if (topic.first_different_sequence) fmt::print("  first different: frame {}\n", *topic.first_different_sequence);
  }
  const bool is_recovered = !verdict.recovered_of.empty() || !verdict.missing_in_recovered.empty();
  fmt::print("{} ticks, {} missing; the file is {}\n", verdict.ticks, verdict.missing_ticks,
             !verdict.whole ? "not whole: risorius info"
             : is_recovered ? "recovered from " + shown(verdict.recovered_of)
                            : "whole");
  for (const std::string& line : verdict.missing_in_recovered) fmt::print("missing: {}\n", shown(line, 400));
  if (verdict.different() > 0) {
    throw UserError(path, fmt::format("{} messages differ from what was recorded", verdict.different()),
                    verdict.missing_ticks > 0 ? "Ticks are missing in it, and stages remember"
                    : verdict.notes.empty()   ? "report this"
                                              : "solve it with the program that recorded it");
  }
  if (verdict.equal() == 0) {
    throw UserError(path, "there is nothing to compare",
                    verdict.not_solved() > 0 ? "the Ticks of its AUs, or those of their marker sets, are missing"
                                             : "no AUs were recorded");
  }
  fmt::print("equal bit for bit{}\n", verdict.missing_in_recovered.empty() ? "" : ", all but what is missing");
}

}  // namespace

void add_verify_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "verify", "solve a recorded session again with its own configuration and rig, and compare bit for bit");
  auto path = std::make_shared<std::string>();
  command->add_option("file", *path, "MCAP file of [record] session")->required();
  command->callback([path] { verify(*path); });
}

}  // namespace risorius
