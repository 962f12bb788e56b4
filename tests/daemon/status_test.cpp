#include "daemon/status.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "daemon/counter_table.h"
#include "daemon/service.h"
#include "support/test_data.h"

namespace risorius {
namespace {

Config on_free_ports() {
  Config config = default_config();
  config.sources[0].listen = "udp://127.0.0.1:0";
  config.output.publish = config.output.control = "tcp://127.0.0.1:*";
  return config;
}

/// Dotted paths of all that is no object; a ledger, a histogram and a map of reasons are one path each.
void add_paths(const nlohmann::json& json, const std::string& prefix, std::span<const CounterRow> rows,
               std::set<std::string>& paths) {
  for (const auto& [key, value] : json.items()) {
    const std::string path = prefix.empty() ? key : prefix + "." + key;
    const auto row = std::ranges::find(rows, path, &CounterRow::name);
    if (!value.is_object()) {
      paths.insert(path);
      continue;
    }
    nlohmann::json rest = value;
    if (row != rows.end()) {
      paths.insert(path);
      if (row->kind == CounterKind::kReasons) continue;
      const std::vector<const char*> own = (row->kind == CounterKind::kLedger || row->kind == CounterKind::kLossLedger)
                                               ? std::vector{"received", "emitted", "dropped", "refused", "held"}
                                               : std::vector{"p50", "p99", "max"};
      for (const char* name : own) {
        EXPECT_TRUE(rest.contains(name)) << path << "." << name;
        rest.erase(name);
      }
    }
    add_paths(rest, path, rows, paths);
  }
}

std::set<std::string> names_of(std::span<const CounterRow> rows) {
  std::set<std::string> names;
  for (const CounterRow& row : rows) names.emplace(row.name);
  return names;
}

TEST(Status, EveryNumberStandsInTheTableAndEveryRowInTheStatus) {
  test::TemporaryFolder folder;
  Config config = on_free_ports();
  config.record.folder = (folder.path() / "rec").string();
  config.record.session = (folder.path() / "session.mcap").string();
  const Service service(config);
  nlohmann::json status = service.status();
  std::set<std::string> of_stream, of_service;
  nlohmann::json face = status.at("streams").at("face");
  face["clock"].update({{"offset_ns", 0}, {"skew_ppm", 0}, {"uncertainty_ns", 0}, {"leaps", 0}});  // once it is known
  add_paths(face, "", stream_counters(), of_stream);
  status.erase("streams");
  add_paths(status, "", service_counters(), of_service);
  EXPECT_EQ(of_stream, names_of(stream_counters()));
  EXPECT_EQ(of_service, names_of(service_counters()));
}

TEST(Status, TheReadmeHasTheTableAsTheProgramPrintsIt) {
  std::ifstream file(std::filesystem::path(RISORIUS_SOURCE_DIR) / "daemon/README.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(counter_tables_markdown()), std::string::npos)
      << "put the output of risoriusd --print-counters into the section Counters";
}

TEST(Status, SummaryOfAFreshServiceIsReadable) {
  const Service service(on_free_ports());
  const std::string summary = summary_of(service.status());
  for (const char* word : {"face", "datagrams", "received 0", "lost 0", "published 0 messages"}) {
    EXPECT_NE(summary.find(word), std::string::npos) << word << " in\n" << summary;
  }
}

}  // namespace
}  // namespace risorius
