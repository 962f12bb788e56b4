#include "replay/takes/au_series.h"

#include <algorithm>
#include <optional>

#include "replay/takes/au_column.h"

namespace risorius {

std::vector<std::size_t> columns_for(const std::vector<std::string>& names, std::string_view wanted) {
  const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names.begin());
  };
  if (const auto column = find(wanted)) return {*column};
  const AuColumn au = parse_au_column(wanted);
  // AU30L and AU30R are opposites, not sides of one movement: neither can be served by the other or by a mean.
  constexpr int kJawSideways = 30;
  if (au.number == 0 || au.number == kJawSideways) return {};
  const std::string both = "AU" + std::to_string(au.number);
  if (au.side != ColumnSide::kNone) {
    const auto column = find(both);
    return column ? std::vector<std::size_t>{*column} : std::vector<std::size_t>{};
  }
  const auto left = find(both + "L"), right = find(both + "R");
  if (left && right) return {*left, *right};
  return {};
}

}  // namespace risorius
