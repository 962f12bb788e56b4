#include "capture/marker_set.h"

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "capture/errors.h"
#include "capture/utf8.h"

namespace risorius {
namespace {

struct Direction {
  std::uint8_t axis;  // 0 left, 1 up, 2 front
  std::int8_t sign;
};

std::optional<Direction> direction_of(char letter) {
  switch (letter) {
    case 'L':
      return Direction{0, 1};
    case 'R':
      return Direction{0, -1};
    case 'U':
      return Direction{1, 1};
    case 'D':
      return Direction{1, -1};
    case 'F':
      return Direction{2, 1};
    case 'B':
      return Direction{2, -1};
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<Axes> Axes::parse(std::string_view letters) {
  if (letters.size() != 3) return std::nullopt;
  Axes axes;
  std::array<bool, 3> seen{};
  for (std::uint8_t i = 0; i < 3; ++i) {
    const auto direction = direction_of(letters[i]);
    if (!direction || seen[direction->axis]) return std::nullopt;
    seen[direction->axis] = true;
    axes.source_of_[direction->axis] = i;
    axes.sign_[direction->axis] = direction->sign;
  }
  return axes;
}

std::string Axes::letters() const {
  static constexpr std::array<std::array<char, 2>, 3> kLetters{{{'L', 'R'}, {'U', 'D'}, {'F', 'B'}}};
  std::string letters(3, '?');
  for (std::size_t axis = 0; axis < 3; ++axis) letters[source_of_[axis]] = kLetters[axis][sign_[axis] > 0 ? 0 : 1];
  return letters;
}

Position Axes::to_world(float x, float y, float z) const noexcept {
  const std::array<float, 3> source{x, y, z};
  return {static_cast<float>(sign_[0]) * source[source_of_[0]], static_cast<float>(sign_[1]) * source[source_of_[1]],
          static_cast<float>(sign_[2]) * source[source_of_[2]]};
}

Position Axes::from_world(Position p) const noexcept {
  std::array<float, 3> source{};
  source[source_of_[0]] = static_cast<float>(sign_[0]) * p.x;
  source[source_of_[1]] = static_cast<float>(sign_[1]) * p.y;
  source[source_of_[2]] = static_cast<float>(sign_[2]) * p.z;
  return {source[0], source[1], source[2]};
}

bool is_rate(double rate_hz) noexcept { return rate_hz >= 0.01 && rate_hz <= 100'000; }

std::vector<std::string> problems_of(const MarkerSet& set) {
  std::vector<std::string> problems;
  if (set.names.empty()) problems.push_back("the marker set has no names");
  if (set.names.size() > kMaxMarkers) {
    problems.push_back(
        fmt::format("{} markers are more than the {} that a frame can hold", set.names.size(), kMaxMarkers));
  }
  std::unordered_set<std::string_view> seen;
  for (const auto& name : set.names) {
    if (name.empty()) problems.push_back("a marker has an empty name");
    if (name.size() > kMaxNameBytes) {
      problems.push_back(fmt::format("marker name \"{}\" is longer than {} bytes", shown(name), kMaxNameBytes));
    }
    if (!is_clean_utf8(name)) {
      problems.push_back(fmt::format("marker name \"{}\" is not UTF-8, or holds control characters", utf8_of(name)));
    }
    if (!name.empty() && !seen.insert(name).second)
      problems.push_back(fmt::format("marker name \"{}\" stands twice", name));
  }
  if (set.rate_hz != 0 && !is_rate(set.rate_hz)) {
    problems.push_back(fmt::format("rate {} Hz is neither 0 (not stated) nor from 0.01 to 100000", set.rate_hz));
  }
  if (!std::isfinite(set.mm_per_unit) || set.mm_per_unit <= 0) {
    problems.push_back(fmt::format("unit of {} mm is not a finite number > 0", set.mm_per_unit));
  }
  return problems;
}

std::vector<int> index_map(const std::vector<std::string>& from, const std::vector<std::string>& to) {
  std::unordered_map<std::string_view, int> index;
  for (std::size_t i = 0; i < from.size(); ++i) index.emplace(from[i], static_cast<int>(i));
  std::vector<int> map;
  map.reserve(to.size());
  for (const auto& name : to) {
    const auto found = index.find(name);
    map.push_back(found == index.end() ? -1 : found->second);
  }
  return map;
}

std::optional<double> parse_unit(std::string_view unit) {
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  return std::nullopt;
}

}  // namespace risorius
