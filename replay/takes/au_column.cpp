#include "replay/takes/au_column.h"

#include <charconv>

namespace risorius {

AuColumn parse_au_column(std::string_view name) {
  constexpr int kMaxNumber = 99;  // FACS codes have one or two digits
  AuColumn column{.name = std::string(name)};
  if (!name.starts_with("AU")) return column;
  std::string_view digits = name.substr(2);
  ColumnSide side = ColumnSide::kNone;
  if (digits.ends_with('L')) side = ColumnSide::kLeft;
  if (digits.ends_with('R')) side = ColumnSide::kRight;
  if (side != ColumnSide::kNone) digits.remove_suffix(1);
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number < 1 || number > kMaxNumber) return column;
  column.number = number;
  column.side = side;
  return column;
}

}  // namespace risorius
