// The versioned table between ARKit's 52 face shapes and AUs (FACS 2002 names): arkit_aus.json, compiled in, or a file
// of the user's. Reading: AU = max over alternatives of sum(weight * shape), mapped from the AU's range to 0..1.
// Writing: shape = sum over AUs of weight * AU, clipped to 1. Everything goes by name; left is the subject's left.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/takes/au_series.h"

namespace risorius {

/// kWhole: one column AU27 is the jaw's whole range. kSplit: AU26 up to 0.6 of it, AU27 above.
enum class JawColumns { kWhole, kSplit };

using ShapeWeights = std::map<std::string, double, std::less<>>;

struct ArkitAu {
  std::string au;                        ///< a column's name, such as "AU12L"
  char agreement = 'A';                  ///< A public tables agree, B a proxy or disagreement, C our choice
  bool is_consequence = false;           ///< of other actions: read for coding, but no action of its own
  std::vector<ShapeWeights> read;        ///< alternatives; empty = cannot be read
  ShapeWeights write;                    ///< empty = not written
  double range_low = 0, range_high = 1;  ///< of the shapes' sum, when reading
  bool for_whole_jaw = true, for_split_jaw = true;
};

struct ArkitTable {
  int version = 0;
  std::string facs_edition;
  std::vector<ArkitAu> aus;
};

/// Throws UserError naming `place`, field, value and remedy.
ArkitTable parse_arkit_table(std::string_view json, const std::string& place);
ArkitTable load_arkit_table(const std::filesystem::path& path);
/// The one that is compiled in.
const ArkitTable& shipped_arkit_table();

/// The table made ready for shapes in a given order. AUs whose shapes are not among them are left out. Reading
/// allocates nothing.
class ArkitReader {
 public:
  ArkitReader(const std::vector<std::string>& shape_names, const ArkitTable& table, JawColumns jaw, bool actions_only);

  const std::vector<std::string>& names() const noexcept { return names_; }
  /// `shapes`: as many as shape names; `aus`: as many as names(). NaN where a shape is NaN.
  void read(std::span<const double> shapes, std::span<double> aus) const noexcept;

 private:
  struct Term {
    std::size_t column;
    double weight;
  };
  struct Reading {
    std::vector<std::vector<Term>> alternatives;  ///< of which the largest counts
    double low, high;
  };
  static double read(const Reading& reading, std::span<const double> shapes) noexcept;

  std::vector<std::string> names_;
  std::vector<Reading> readings_;
};

/// AUs of a series of shapes, without consequences of other actions if `actions_only`. AUs whose shapes the series
/// lacks are left out. Values are not clipped above (ARKit's reach 1.003), but never below 0; NaN where a shape is NaN.
AuSeries aus_of_shapes(const AuSeries& shapes, const ArkitTable& table, JawColumns jaw = JawColumns::kWhole,
                       bool actions_only = false);

/// Shapes of a series of AUs, 0 to 1: all shapes that the table writes. An AU without a side in the series goes to
/// both; AUs that the table does not know are left out. NaN counts as 0.
AuSeries shapes_of_aus(const AuSeries& aus, const ArkitTable& table);

}  // namespace risorius
