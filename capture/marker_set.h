// Marker identity is the name. A marker set says which names the entries of a frame have, and in which
// unit and axes the source's numbers are.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/frames.h"

namespace risorius {

/// The longest marker name, in bytes of UTF-8.
inline constexpr std::size_t kMaxNameBytes = 63;

/// The axes of a source's world, as three letters: the direction in which its x, y and z grow, seen by the subject:
/// L left, R right, U up, D down, F front (out of the face), B back. Risorius itself uses "LUF".
/// A left-handed world (such as "RUF") is legitimate: the conversion undoes the mirror.
class Axes {
 public:
  Axes() = default;  ///< "LUF"
  /// Empty if the letters are not three different directions.
  static std::optional<Axes> parse(std::string_view letters);
  std::string letters() const;
  /// Source coordinates (any unit) to Risorius axes; exact, a signed permutation.
  Position to_world(float x, float y, float z) const noexcept;
  /// The inverse of to_world.
  Position from_world(Position p) const noexcept;
  friend bool operator==(const Axes&, const Axes&) = default;

 private:
  std::array<std::uint8_t, 3> source_of_{0, 1, 2};  ///< which source coordinate feeds left, up, front
  std::array<std::int8_t, 3> sign_{1, 1, 1};
};

/// Names, rate, unit and axes of a stream of marker frames.
struct MarkerSet {
  std::uint32_t id = 0;            ///< the sender's number for this set; frames name it
  std::vector<std::string> names;  ///< unique, 1 to kMaxMarkers of them, 1 to kMaxNameBytes bytes each
  double rate_hz = 0;              ///< 0 = not stated
  double mm_per_unit = 1;          ///< of the source's numbers: 1 mm, 10 cm, 1000 m
  Axes axes;                       ///< of the source's numbers; frames inside Risorius are always LUF

  friend bool operator==(const MarkerSet&, const MarkerSet&) = default;
};

/// What is wrong with the set, one sentence each; empty if nothing.
std::vector<std::string> problems_of(const MarkerSet& set);

/// One that a set may state: 0.01 to 100000 Hz.
bool is_rate(double rate_hz) noexcept;

/// For each name of `to` its index in `from`, or -1.
std::vector<int> index_map(const std::vector<std::string>& from, const std::vector<std::string>& to);

/// "mm", "cm" or "m" to millimetres per unit; empty if unknown.
std::optional<double> parse_unit(std::string_view unit);

}  // namespace risorius
