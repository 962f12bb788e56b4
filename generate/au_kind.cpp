#include "generate/au_kind.h"

#include <algorithm>
#include <charconv>

namespace risorius {
namespace {

/// 0 where the name is not "AU" and a number, and perhaps a side.
int number_of(std::string_view name) noexcept {
  if (!name.starts_with("AU")) return 0;
  int number = 0;
  const auto [end, error] = std::from_chars(name.data() + 2, name.data() + name.size(), number);
  if (error != std::errc{}) return 0;
  const std::string_view rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
  return rest.empty() || rest == "L" || rest == "R" ? number : 0;
}

std::string other_side(const std::string& name) {
  if (name.ends_with("Left")) return name.substr(0, name.size() - 4) + "Right";
  if (name.ends_with("Right")) return name.substr(0, name.size() - 5) + "Left";
  const bool has_side = number_of(name) != 0 && (name.back() == 'L' || name.back() == 'R');
  return has_side ? name.substr(0, name.size() - 1) + (name.back() == 'L' ? 'R' : 'L') : name;
}

}  // namespace

AuKind kind_of_au(std::string_view name) noexcept {
  if (name == "mouthLeft" || name == "mouthRight") return AuKind::kMouth;
  const int number = number_of(name);
  switch (number) {
    case 1:
    case 2:
    case 4:
      return AuKind::kBrow;
    case 5:
    case 7:
    case 41:
    case 42:
    case 43:
    case 44:
    case 45:
    case 46:
      return AuKind::kLid;
    case 6:
    case 9:
    case 10:
    case 11:
      return AuKind::kMidface;
    case 26:
    case 27:
    case 29:
    case 30:
      return AuKind::kJaw;
    default:
      return number >= 12 && number <= 38 ? AuKind::kMouth : AuKind::kOther;
  }
}

std::vector<std::size_t> other_sides(const std::vector<std::string>& names) {
  std::vector<std::size_t> columns;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto other = std::find(names.begin(), names.end(), other_side(names[k]));
    columns.push_back(other == names.end() ? k : static_cast<std::size_t>(other - names.begin()));
  }
  return columns;
}

}  // namespace risorius
