#include "replay/takes/trc_reader.h"

#include <algorithm>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/takes/csv_text.h"
#include "replay/takes/take_names.h"

namespace risorius {

TrcReader::TrcReader(const std::filesystem::path& path, const TakeOptions& options)
    : RowTakeReader(path, Cells::kTabs) {
  if (!next_line()) throw UserError(path.string(), "the file is empty", "export the take again");
  if (cells().empty() || cells()[0] != "PathFileType") {
    throw UserError(place(), "a TRC file begins with PathFileType", "check that this is a TRC file of markers");
  }
  const double rate_hz = read_properties(options);
  Header header{.first_cells = read_names(), .row_cells = 0, .has_unnamed_cells = true, .rate_hz = rate_hz};
  header.row_cells = header.first_cells.empty() ? 0 : header.first_cells.back() + 3;
  if (!next_line()) throw UserError(path.string(), "the line X1 Y1 Z1 ... is missing", "export the take again");
  begin_rows(std::move(header), options);
}

/// Returns the rate, 0 if it is not stated. The properties stand in any order, by name.
double TrcReader::read_properties(const TakeOptions& options) {
  if (!next_line()) throw UserError(place(), "the header ends here", "export the take again");
  const std::vector<std::string> names(cells().begin(), cells().end());
  if (!next_line()) throw UserError(place(), "the header ends here", "export the take again");
  double rate_hz = 0;
  for (std::size_t i = 0; i < std::min(names.size(), cells().size()); ++i) {
    const auto value = parse_double(cells()[i]);
    if (names[i] == "Units" && !options.mm_per_unit) {
      const auto mm = parse_unit(cells()[i]);
      if (!mm) {
        throw UserError(place() + ", Units", fmt::format("'{}' is no unit that is known here", shown(cells()[i])),
                        "give the unit with --units");
      }
      info_.markers.mm_per_unit = *mm;
    } else if (names[i] == "DataRate") {
      if (!value || !(*value > 0)) {
        throw UserError(place() + ", DataRate", fmt::format("'{}' is no rate", shown(cells()[i])),
                        "give the rate in Hz");
      }
      rate_hz = *value;
    } else if (names[i] == "NumFrames" && value && *value >= 0 && *value < 1e15) {
      info_.frame_count = static_cast<std::uint64_t>(*value);
    }
  }
  return rate_hz;
}

/// A name stands above its marker's x; the cells above y and z are empty.
std::vector<std::size_t> TrcReader::read_names() {
  if (!next_line() || cells().size() < 3) {
    throw UserError(place(), "the line with Frame#, Time and the marker names is missing", "export the take again");
  }
  std::vector<std::size_t> first_cells;
  for (std::size_t cell = 2; cell < cells().size(); ++cell) {
    if (cells()[cell].empty()) continue;
    if (!first_cells.empty() && cell < first_cells.back() + 3) {
      throw UserError(place(),
                      fmt::format("marker name '{}' stands above another marker's coordinates", shown(cells()[cell])),
                      "each name has three cells");
    }
    first_cells.push_back(cell);
    info_.markers.names.push_back(marker_name_of(cells()[cell], info_));
  }
  return first_cells;
}

}  // namespace risorius
