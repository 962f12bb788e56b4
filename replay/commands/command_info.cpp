// risorius info: what a session's file (or any MCAP file) holds, and what is missing in it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "capture/frames.h"
#include "replay/commands/session_commands.h"
#include "replay/progress_line.h"
#include "replay/session/session_reader.h"
#include "replay/session/session_recover.h"

namespace risorius {
namespace {

constexpr std::uint64_t kProgressStride = 256;

std::string rig_name(const StreamFacts& stream) {
  const auto rig = nlohmann::json::parse(stream.rig_json, nullptr, false);
  return rig.is_object() && rig.contains("name") && rig.at("name").is_string() ? rig.at("name").get<std::string>()
                                                                               : "no rig that can be read";
}

std::optional<MessageTimes> times_of(const SessionReader& reader) {
  std::optional<MessageTimes> times;
  for (const auto& [name, topic] : reader.topics()) {
    if (topic.messages == 0) continue;
    if (!times) times = {topic.first_ns, topic.last_ns};
    times->first_ns = std::min(times->first_ns, topic.first_ns);
    times->last_ns = std::max(times->last_ns, topic.last_ns);
  }
  return times;
}

void print_head(const SessionReader& reader) {
  fmt::print("{}: {} bytes, {}\n", reader.file().path().string(), reader.bytes(),
             !reader.file().whole()              ? "torn: without its end"
             : reader.file().damage_count() == 0 ? "whole"
                                                 : "whole, but damaged");
  for (const auto& [key, value] : reader.session()) {
    if (!value.empty()) fmt::print("  {:<16} {}\n", shown(key), shown(value, 200));
  }
  for (const StreamFacts& stream : reader.streams())
    fmt::print("  stream           {} ({}), rig {}\n", shown(stream.name), shown(stream.protocol),
               shown(rig_name(stream)));
}

void print_topics(const SessionReader& reader) {
  fmt::print("{:<28} {:<16} {:>9} {:>12} {:>8}  {}\n", "topic", "encoding", "messages", "bytes", "missing", "from, to");
  for (const auto& [name, topic] : reader.topics()) {
    fmt::print("{:<28} {:<16} {:>9} {:>12} {:>8}  {}, {:.3f} s\n", shown(name), shown(topic.encoding), topic.messages,
               topic.bytes, topic.missing, utc_text(topic.first_ns),
               static_cast<double>(difference_ns(topic.last_ns, topic.first_ns)) * 1e-9);
  }
  for (const auto& [name, topic] : reader.topics()) {
    for (const std::string& line : gap_lines(name, topic)) fmt::print("missing: {}\n", line);
  }
}

void print_texts(const char* title, const McapTexts& texts) {
  if (!texts.empty()) fmt::print("{}:\n", title);
  for (const auto& [key, value] : texts) fmt::print("  {} {}\n", shown(key), shown(value, 400));
}

void info(const std::string& path, bool print_config) {
  SessionReader reader(path);
  {
    ProgressLine progress("reading", "bytes");
    for (std::uint64_t done = 0; reader.next(); ++done) {
      if (done % kProgressStride == 0) progress.show(reader.bytes_read(), reader.bytes());
    }
  }
  if (print_config) {
    reader.require_session();
    fmt::print("{}", reader.config_toml());
    return;
  }
  print_head(reader);
  print_topics(reader);
  const McapReader& file = reader.file();
  for (const std::string& line :
       damage_lines(file.damages(), file.damage_count(), file.damaged_bytes(), times_of(reader)))
    fmt::print("damaged: {}\n", line);
  print_texts("recovered", reader.recovery());
  print_texts("report of the recorder", reader.report());
  if (reader.report().empty() && !reader.session().empty())
    fmt::print("no report: the recorder did not come to its end\n");
  if (!file.whole() || file.damage_count() > 0) fmt::print("make it whole: risorius recover {}\n", path);
}

}  // namespace

void add_info_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("info", "what a recorded session (MCAP) holds, and what is missing in it");
  auto path = std::make_shared<std::string>();
  auto print_config = std::make_shared<bool>(false);
  command->add_option("file", *path, "MCAP file")->required();
  command->add_flag("--config", *print_config, "print the configuration that it was recorded with instead");
  command->callback([path, print_config] { info(*path, *print_config); });
}

}  // namespace risorius
