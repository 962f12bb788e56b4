#include "replay/performer/expression_vector.h"

#include <charconv>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/takes/au_column.h"

namespace risorius {
namespace {

std::vector<std::size_t> columns_of(std::string_view au, const std::vector<std::string>& names) {
  std::vector<std::size_t> columns;
  const AuColumn wanted = parse_au_column(au);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const AuColumn column = parse_au_column(names[k]);
    const bool same = wanted.number != 0 && column.number == wanted.number &&
                      (wanted.side == ColumnSide::kNone || wanted.side == column.side);
    if (names[k] == au || same) columns.push_back(k);
  }
  if (columns.empty() && au == "AU27") return columns_of("AU26", names);
  return columns;
}

}  // namespace

std::string expression_names(const ExpressionTable& table) {
  std::string names;
  for (const auto& [name, variants] : table.expressions) names += (names.empty() ? "" : ", ") + name;
  return names;
}

ExpressionVector expression_vector(std::string_view expression, const std::vector<std::string>& names,
                                   const ExpressionTable& table) {
  const std::size_t colon = expression.find(':');
  const std::string_view name = expression.substr(0, colon);
  const auto found = table.expressions.find(name);
  if (found == table.expressions.end())
    throw UserError(shown(expression), "is no expression", "there are: " + expression_names(table));
  std::size_t variant = 1;
  if (colon != std::string_view::npos) {
    const std::string_view digits = expression.substr(colon + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), variant);
    if (error != std::errc() || end != digits.data() + digits.size() || variant < 1 || variant > found->second.size())
      throw UserError(shown(expression), "names no variant of it",
                      fmt::format("{} has variants 1 to {}", name, found->second.size()));
  }
  ExpressionVector result{std::vector<double>(names.size(), 0.0), {}};
  for (const auto& [au, intensity] : found->second[variant - 1]) {
    const std::vector<std::size_t> columns = columns_of(au, names);
    if (columns.empty()) result.masked.push_back(au);
    for (const std::size_t column : columns) result.intensities[column] = intensity;
  }
  return result;
}

}  // namespace risorius
