// The report of a bench: a table on the screen and build/bench/NAME.json, a list of {name, value, unit, bar, ok}.
// Names, units and bars stand in tests/bench/bars.tsv alone; a row of the table that was not measured is not ok.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace risorius::bench {

class BenchReport {
 public:
  /// Reads the rows of `bench` from the committed table; throws if there are none.
  explicit BenchReport(std::string bench);

  /// A measured value; the name must stand in the table.
  void add(const std::string& name, double value);

  /// Prints the table, writes the JSON; 0 if every row is ok, else 1.
  int finish() const;

 private:
  struct Row {
    std::string unit, bar;
    bool measured = false;
    double value = 0;
    int order = 0;
  };
  static bool is_ok(const Row& row);

  std::string bench_;
  std::map<std::string, Row> rows_;
};

}  // namespace risorius::bench
