#include "replay/performer/expression_table.h"

#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "replay/shipped_json.h"

namespace risorius {
namespace {

using Json = nlohmann::json;

std::vector<AuTargets> variants_of(const Json& list, const std::string& place) {
  const std::string remedy = R"(write a list of variants such as {"AU6": 0.7, "AU12": 0.9}, intensities 0 to 1)";
  if (!list.is_array() || list.empty()) throw UserError(place, list.dump(), remedy);
  std::vector<AuTargets> variants;
  for (const Json& variant : list) {
    AuTargets& targets = variants.emplace_back();
    if (!variant.is_object()) throw UserError(place, variant.dump(), remedy);
    for (const auto& [au, intensity] : variant.items()) {
      if (!intensity.is_number() || !(intensity.get<double>() >= 0 && intensity.get<double>() <= 1))
        throw UserError(place, au + " = " + intensity.dump(), remedy);
      targets.emplace(au, intensity.get<double>());
    }
  }
  return variants;
}

}  // namespace

ExpressionTable parse_expression_table(std::string_view json, const std::string& place) {
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_object() || root.value("format", Json()) != "risorius-expressions" || root.value("version", Json()) != 1)
    throw UserError(place, "not a table of expressions, version 1", R"(it says "format": "risorius-expressions")");
  ExpressionTable table;
  const Json expressions = root.value("expressions", Json::object()), sets = root.value("sets", Json::object());
  for (const auto& [name, list] : expressions.items())
    table.expressions.emplace(name, variants_of(list, place + ", expressions." + name));
  for (const auto& [set, names] : sets.items()) {
    for (const Json& name : names) {
      if (!name.is_string() || !table.expressions.contains(name.get<std::string>()))
        throw UserError(place + ", sets." + set, name.dump() + " is no expression of the table", "name one of them");
      table.sets[set].push_back(name.get<std::string>());
    }
  }
  return table;
}

const ExpressionTable& shipped_expression_table() {
  static const ExpressionTable table = parse_expression_table(shipped_json("expressions"), "expressions");
  return table;
}

}  // namespace risorius
