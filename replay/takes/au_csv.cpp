#include "replay/takes/au_csv.h"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <stdexcept>
#include <unordered_set>

#include "capture/errors.h"
#include "replay/takes/csv_text.h"
#include "replay/takes/take.h"

namespace risorius {
namespace {

std::uint64_t read_frame_number(const CsvFile& file, const AuSeries& series) {
  const std::string_view cell = file.cell(0);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || end != cell.data() + cell.size()) file.fail_at(0, "give the frame's number, from 0");
  const auto last = series.frames.empty() ? std::nullopt : std::optional(series.frames.back());
  if (last && number <= *last) {
    file.fail_at(0, fmt::format("frame {} does not come after frame {}", number, *last),
                 "sort the lines by frame, and remove duplicates");
  }
  if (last && number - *last > kLongestLeap) {
    file.fail_at(
        0, fmt::format("the frame numbers leap from {} to {}", *last, number),
        fmt::format("correct the number, or cut the series in two: at most {} frames in a row may lack", kLongestLeap));
  }
  return number;
}

double read_intensity(const CsvFile& file, std::size_t column) {
  if (file.cell(column).empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto intensity = parse_double(file.cell(column));
  if (!intensity || std::isnan(*intensity))
    file.fail_at(column, "write a number with a decimal point, or leave it empty where the AU is not observed");
  if (!(*intensity >= kLeastIntensity && *intensity <= kMostIntensity)) {
    file.fail_at(
        column, fmt::format("'{}' is no intensity", shown(file.cell(column))),
        fmt::format("an intensity is 0 to 1, at most 1.2 (accepted: {} to {}); multiply those of 0 to 5 by 0.2",
                    kLeastIntensity, kMostIntensity));
  }
  return *intensity;
}

}  // namespace

AuCsvWriter::AuCsvWriter(const std::filesystem::path& path, const std::vector<std::string>& au_names)
    : au_count_(au_names.size()), file_(path) {
  if (au_names.empty() || au_names.size() > kMaxAus)
    throw UserError(path.string(), std::to_string(au_names.size()) + " AUs", "1 to 64 can be written");
  line_ = "Frame";
  for (const std::string& name : au_names) {
    line_ += ',';
    append_text(line_, name);
  }
  line_ += '\n';
  file_.write(line_);
}

void AuCsvWriter::write(const AuFrame& frame) {
  if (frame.count != au_count_)
    throw std::invalid_argument("AuCsvWriter: a frame of " + std::to_string(frame.count) + " AUs for " +
                                std::to_string(au_count_) + " names");
  line_.clear();
  append_number(line_, frame.header.sequence);
  for (std::size_t i = 0; i < au_count_; ++i) {
    line_ += ',';
    if (frame.state[i] == AuState::kObserved) append_number(line_, frame.intensity[i]);
  }
  line_ += '\n';
  file_.write(line_);
}

void AuCsvWriter::finish() { file_.commit(); }

AuSeries load_au_csv(const std::filesystem::path& path) {
  CsvFile file(path);
  const std::vector<std::string>& columns = file.columns();
  const std::string header_place = path.string() + ", line 1";
  if (columns[0] != "Frame" && columns[0] != "frame")
    throw UserError(header_place, "the first column is '" + columns[0] + "'",
                    "it must be Frame, then one column per AU");
  if (columns.size() < 2) throw UserError(header_place, "no AU columns", "write Frame,AU1L,AU1R,...");
  std::unordered_set<std::string> seen;
  for (const std::string& name : columns)
    if (name.empty() || !seen.insert(name).second)
      throw UserError(header_place, "column '" + name + "' has no name or stands twice", "name each AU once");

  AuSeries series;
  series.names.assign(columns.begin() + 1, columns.end());
  while (file.next_row()) {
    series.frames.push_back(read_frame_number(file, series));
    std::vector<double>& row = series.intensities.emplace_back();
    row.reserve(series.names.size());
    for (std::size_t column = 1; column < columns.size(); ++column) row.push_back(read_intensity(file, column));
  }
  if (series.frames.empty()) throw UserError(path.string(), "has no frames", "give a series with frames");
  return series;
}

}  // namespace risorius
