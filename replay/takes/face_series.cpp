#include "replay/takes/face_series.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

#include "capture/errors.h"
#include "replay/takes/au_column.h"
#include "replay/takes/au_csv.h"
#include "replay/takes/live_link_csv.h"

namespace risorius {
namespace {

std::set<std::string, std::less<>> shapes_of(const ArkitTable& table) {
  std::set<std::string, std::less<>> shapes;
  for (const ArkitAu& au : table.aus) {
    for (const ShapeWeights& alternative : au.read)
      for (const auto& [shape, weight] : alternative) shapes.insert(shape);
    for (const auto& [shape, weight] : au.write) shapes.insert(shape);
  }
  return shapes;
}

bool is_au(const std::string& name) { return parse_au_column(name).number > 0; }

/// In either spelling, each once.
void expect_each_once(const std::filesystem::path& path, const std::vector<std::string>& names) {
  std::set<std::string, std::less<>> seen;
  for (const std::string& name : names) {
    if (!seen.insert(name).second)
      throw UserError(path.string() + ", line 1", "shape '" + name + "' stands twice", "name each shape once");
  }
}

/// True if the columns are shapes, which then have ARKit's names. Beside an AU, a shape is what the table reads no AU
/// from (mouthLeft): an AU series may have it.
bool name_shapes(const std::filesystem::path& path, const ArkitTable& table, AuSeries& series) {
  if (std::ranges::any_of(series.names, is_au)) return false;
  const std::set<std::string, std::less<>> shapes = shapes_of(table);
  std::vector<std::string> names;
  for (const std::string& name : series.names) names.push_back(arkit_name(name));
  if (std::ranges::none_of(names, [&](const std::string& name) { return shapes.contains(name); })) return false;
  expect_each_once(path, names);
  series.names = std::move(names);
  return true;
}

}  // namespace

FaceSeries load_face_series(const std::filesystem::path& path, const FaceSeriesOptions& options) {
  const ArkitTable& table = options.table != nullptr ? *options.table : shipped_arkit_table();
  if (is_live_link_csv(path)) {
    LiveLinkTake take = load_live_link_csv(path, options.rate_hz);
    return {aus_of_shapes(take.shapes, table, options.jaw, true), take.rate_hz, std::move(take.warnings)};
  }
  FaceSeries result{load_au_csv(path), options.rate_hz, {}};
  if (!name_shapes(path, table, result.aus)) return result;
  const std::vector<std::string> shapes = result.aus.names;
  result.aus = aus_of_shapes(result.aus, table, options.jaw, true);
  if (result.aus.names.empty()) {
    throw UserError(path.string() + ", line 1", fmt::format("no AU can be read from {}", fmt::join(shapes, ", ")),
                    "give more of ARKit's shapes, or columns of AUs");
  }
  result.warnings.push_back(fmt::format("its columns are face shapes ({}): read as {}", fmt::join(shapes, " "),
                                        fmt::join(result.aus.names, " ")));
  return result;
}

}  // namespace risorius
