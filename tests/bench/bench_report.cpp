#include "bench/bench_report.h"

#include <algorithm>
#include <fmt/core.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace risorius::bench {

BenchReport::BenchReport(std::string bench) : bench_(std::move(bench)) {
  std::ifstream table(std::filesystem::path(RISORIUS_SOURCE_DIR) / "tests/bench/bars.tsv");
  std::string line;
  while (std::getline(table, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::string owner, name;
    Row row;
    std::getline(cells, owner, '\t');
    std::getline(cells, name, '\t');
    std::getline(cells, row.unit, '\t');
    std::getline(cells, row.bar, '\t');
    row.order = static_cast<int>(rows_.size());
    if (owner == bench_) rows_.emplace(name, row);
  }
  if (rows_.empty()) throw std::runtime_error("tests/bench/bars.tsv has no row for the bench " + bench_);
}

void BenchReport::add(const std::string& name, double value) {
  const auto row = rows_.find(name);
  if (row == rows_.end()) throw std::runtime_error("tests/bench/bars.tsv has no row \"" + name + "\" for " + bench_);
  row->second.measured = true;
  row->second.value = value;
}

bool BenchReport::is_ok(const Row& row) {
  if (!row.measured) return false;
  if (row.bar == "-") return true;  // reported, not judged
  const double bound = std::stod(row.bar.substr(2));
  return row.bar.starts_with("<=") ? row.value <= bound : row.value >= bound;
}

int BenchReport::finish() const {
  std::vector<std::pair<std::string, Row>> ordered(rows_.begin(), rows_.end());
  std::ranges::sort(ordered, {}, [](const auto& entry) { return entry.second.order; });
  nlohmann::json json = nlohmann::json::array();
  bool all_ok = true;
  fmt::print("\n{:<58} {:>12} {:<9} {:>10}  {}\n", bench_, "value", "unit", "bar", "ok");
  for (const auto& [name, row] : ordered) {
    const bool ok = is_ok(row);
    all_ok = all_ok && ok;
    fmt::print("{:<58} {:>12} {:<9} {:>10}  {}\n", name, row.measured ? fmt::format("{:.4g}", row.value) : "missing",
               row.unit, row.bar, ok ? "yes" : "NO");
    json.push_back({{"name", name},
                    {"value", row.measured ? nlohmann::json(row.value) : nlohmann::json()},
                    {"unit", row.unit},
                    {"bar", row.bar},
                    {"ok", ok}});
  }
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / (bench_ + ".json")) << json.dump(1) << '\n';
  fmt::print("written: build/bench/{}.json\n", bench_);
  return all_ok ? 0 : 1;
}

}  // namespace risorius::bench
