#include "replay/takes/arkit_aus.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/errors.h"
#include "replay/shipped_json.h"

namespace risorius {
namespace {

using Json = nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Reads the table's rows; every complaint names the row.
class TableParser {
 public:
  explicit TableParser(std::string place) : place_(std::move(place)) {}

  ArkitTable parse(std::string_view json) {
    const Json root = Json::parse(json, nullptr, false);
    if (!root.is_object()) throw UserError(place_, "not a JSON object", "see replay/README.md, \"ARKit table\"");
    if (root.value("format", Json()) != "risorius-arkit-aus")
      throw UserError(place_, "\"format\" is not \"risorius-arkit-aus\"", "is this an ARKit table?");
    if (root.value("version", Json()) != 1)
      throw UserError(place_, "version " + root.value("version", Json()).dump() + " is not known",
                      "this program reads version 1");
    ArkitTable table{.version = 1};
    const Json edition = root.value("facs_edition", Json());
    if (!edition.is_string()) throw UserError(place_, "no \"facs_edition\"", "write \"facs_edition\": \"2002\"");
    table.facs_edition = edition.get<std::string>();
    const Json rows = root.value("aus", Json());
    if (!rows.is_array() || rows.empty()) throw UserError(place_, "no \"aus\"", "write a list of rows");
    for (const Json& row : rows) read_row(row, table);
    return table;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const {
    throw UserError(place_ + ", aus." + au_, problem, remedy);
  }

  ShapeWeights weights_of(const Json& object, const char* key) const {
    const std::string remedy = R"(write {"SHAPE": WEIGHT, ...}, such as {"mouthSmile": 1})";
    if (!object.is_object()) fail(fmt::format("\"{}\": {} is not an object", key, object.dump()), remedy);
    ShapeWeights weights;
    for (const auto& [shape, weight] : object.items()) {
      if (!weight.is_number() || !std::isfinite(weight.get<double>()))
        fail(fmt::format("\"{}\".{} = {} is not a number", key, shape, weight.dump()), remedy);
      weights.emplace(shape, weight.get<double>());
    }
    return weights;
  }

  void read_row(const Json& row, ArkitTable& table) {
    au_ = std::to_string(table.aus.size());
    if (!row.is_object() || !row.value("au", Json()).is_string()) fail("no \"au\"", R"(write "au": "AU12")");
    au_ = row.at("au").get<std::string>();
    ArkitAu au{.au = au_};
    const Json agreement = row.value("class", Json());
    if (agreement != "A" && agreement != "B" && agreement != "C")
      fail("\"class\" is " + agreement.dump(), "A: public tables agree; B: a proxy; C: our choice");
    au.agreement = agreement.get_ref<const std::string&>().front();
    au.is_consequence = row.value("consequence", Json()) == true;
    const Json read = row.value("read", Json());
    if (!read.is_array()) fail("\"read\" is no list", "write a list of alternatives; empty = cannot be read");
    for (const Json& alternative : read) au.read.push_back(weights_of(alternative, "read"));
    au.write = weights_of(row.value("write", Json::object()), "write");
    read_range(row, au);
    const Json jaw = row.value("jaw", Json());
    au.for_whole_jaw = jaw != "split";
    au.for_split_jaw = jaw != "whole";
    if (row.value("sides", Json()) != true) {
      table.aus.push_back(std::move(au));
      return;
    }
    table.aus.push_back(one_side(au, "L", "Left"));
    table.aus.push_back(one_side(au, "R", "Right"));
  }

  void read_range(const Json& row, ArkitAu& au) const {
    const auto found = row.find("range");
    if (found == row.end()) return;
    const bool good = found->is_array() && found->size() == 2 && (*found)[0].is_number() && (*found)[1].is_number() &&
                      (*found)[0].get<double>() < (*found)[1].get<double>();
    if (!good) fail("\"range\": " + found->dump(), "write \"range\": [LOW, HIGH]");
    au.range_low = (*found)[0].get<double>();
    au.range_high = (*found)[1].get<double>();
  }

  static ArkitAu one_side(ArkitAu au, const char* letter, const char* suffix) {
    au.au += letter;
    const auto named = [suffix](const ShapeWeights& weights) {
      ShapeWeights sided;
      for (const auto& [shape, weight] : weights) sided.emplace(shape + suffix, weight);
      return sided;
    };
    for (ShapeWeights& alternative : au.read) alternative = named(alternative);
    au.write = named(au.write);
    return au;
  }

  std::string place_, au_;
};

std::map<std::string, std::size_t, std::less<>> index_of(const std::vector<std::string>& names) {
  std::map<std::string, std::size_t, std::less<>> index;
  for (std::size_t i = 0; i < names.size(); ++i) index.emplace(names[i], i);
  return index;
}

}  // namespace

ArkitTable parse_arkit_table(std::string_view json, const std::string& place) { return TableParser(place).parse(json); }

ArkitTable load_arkit_table(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(path))
    throw UserError(path.string(), "cannot be read", "check the path");
  const std::string json((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return parse_arkit_table(json, path.string());
}

const ArkitTable& shipped_arkit_table() {
  static const ArkitTable table = parse_arkit_table(shipped_json("arkit_aus"), "arkit_aus");
  return table;
}

ArkitReader::ArkitReader(const std::vector<std::string>& shape_names, const ArkitTable& table, JawColumns jaw,
                         bool actions_only) {
  const auto column_of = index_of(shape_names);
  for (const ArkitAu& au : table.aus) {
    const bool wanted = jaw == JawColumns::kWhole ? au.for_whole_jaw : au.for_split_jaw;
    if (!wanted || au.read.empty() || (actions_only && au.is_consequence)) continue;
    Reading reading{{}, au.range_low, au.range_high};
    bool complete = true;
    for (const ShapeWeights& weights : au.read) {
      auto& terms = reading.alternatives.emplace_back();
      for (const auto& [shape, weight] : weights) {
        const auto column = column_of.find(shape);
        complete = complete && column != column_of.end();
        if (complete) terms.push_back({column->second, weight});
      }
    }
    if (!complete) continue;
    names_.push_back(au.au);
    readings_.push_back(std::move(reading));
  }
}

double ArkitReader::read(const Reading& reading, std::span<const double> shapes) noexcept {
  double largest = kNone;
  for (const auto& terms : reading.alternatives) {
    double sum = 0;
    for (const Term& term : terms) sum += term.weight * shapes[term.column];
    if (std::isnan(sum)) return kNone;
    if (!(largest >= sum)) largest = sum;
  }
  const double value = (largest - reading.low) / (reading.high - reading.low);
  return reading.high < 1 ? std::clamp(value, 0.0, 1.0) : std::max(0.0, value);
}

void ArkitReader::read(std::span<const double> shapes, std::span<double> aus) const noexcept {
  for (std::size_t i = 0; i < readings_.size(); ++i) aus[i] = read(readings_[i], shapes);
}

AuSeries aus_of_shapes(const AuSeries& shapes, const ArkitTable& table, JawColumns jaw, bool actions_only) {
  const ArkitReader reader(shapes.names, table, jaw, actions_only);
  AuSeries aus{.names = reader.names(), .frames = shapes.frames};
  for (const auto& row : shapes.intensities) reader.read(row, aus.intensities.emplace_back(aus.names.size()));
  return aus;
}

AuSeries shapes_of_aus(const AuSeries& aus, const ArkitTable& table) {
  const auto column_of = index_of(aus.names);
  const bool split_jaw = column_of.contains("AU26");
  AuSeries shapes{.frames = aus.frames};
  std::set<std::string, std::less<>> names;
  for (const ArkitAu& au : table.aus) {
    for (const auto& [shape, weight] : au.write) names.insert(shape);
  }
  shapes.names.assign(names.begin(), names.end());
  const auto shape_index = index_of(shapes.names);
  struct Term {
    std::vector<std::size_t> columns;  ///< of which the mean counts
    std::size_t shape;
    double weight;
  };
  std::vector<Term> terms;
  for (const ArkitAu& au : table.aus) {
    if (!(split_jaw ? au.for_split_jaw : au.for_whole_jaw)) continue;
    const std::vector<std::size_t> columns = columns_for(aus.names, au.au);
    if (columns.empty()) continue;
    for (const auto& [shape, weight] : au.write) terms.push_back({columns, shape_index.at(shape), weight});
  }
  for (const auto& row : aus.intensities) {
    auto& out = shapes.intensities.emplace_back(shapes.names.size(), 0.0);
    for (const Term& term : terms) {
      double sum = 0;
      for (const std::size_t column : term.columns) sum += std::isnan(row[column]) ? 0 : row[column];
      out[term.shape] += term.weight * sum / static_cast<double>(term.columns.size());
    }
    for (double& value : out) value = std::clamp(value, 0.0, 1.0);
  }
  return shapes;
}

}  // namespace risorius
