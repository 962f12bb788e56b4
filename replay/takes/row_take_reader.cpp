#include "replay/takes/row_take_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/plausible_position.h"
#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

constexpr std::string_view kBlanks = " \t";
constexpr std::size_t kFrameCell = 0, kTimeCell = 1;
/// Times are printed with few digits; a rate this near a whole number is that number.
constexpr double kWholeRate = 2e-3;

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

}  // namespace

RowTakeReader::RowTakeReader(const std::filesystem::path& path, Cells cells)
    : separation_(cells), file_(path, std::ios::binary) {
  info_.path = path;
  if (!file_ || std::filesystem::is_directory(path)) {
    throw UserError(path.string(), "cannot be opened", "check the path and its permissions");
  }
}

bool RowTakeReader::next_line() {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (!std::getline(file_, line_)) {
    if (file_.bad()) throw UserError(info_.path.string(), "cannot be read", "check the disk");
    return false;
  }
  if (++line_number_ == 1 && line_.starts_with(kByteOrderMark)) line_.erase(0, kByteOrderMark.size());
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  cells_.clear();
  const std::string_view text = line_;
  if (separation_ == Cells::kTabs) {
    for (std::size_t at = 0;;) {
      const std::size_t end = std::min(text.find('\t', at), text.size());
      cells_.push_back(trimmed(text.substr(at, end - at)));
      if (end == text.size()) break;
      at = end + 1;
    }
  } else {
    for (std::size_t at = text.find_first_not_of(kBlanks); at != std::string_view::npos;) {
      const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
      cells_.push_back(text.substr(at, end - at));
      at = text.find_first_not_of(kBlanks, end);
    }
  }
  while (!cells_.empty() && cells_.back().empty()) cells_.pop_back();
  return true;
}

std::string RowTakeReader::place() const { return info_.path.string() + ", line " + std::to_string(line_number_); }

bool RowTakeReader::next_row() {
  while (next_line()) {
    if (!cells_.empty()) return true;
  }
  return false;
}

void RowTakeReader::begin_rows(Header header, const TakeOptions& options) {
  header_ = std::move(header);
  rows_begin_ = file_.tellg();
  rows_begin_line_ = line_number_;
  info_.markers.axes = options.axes.value_or(Axes());
  if (options.mm_per_unit) info_.markers.mm_per_unit = *options.mm_per_unit;
  const double rate_hz = options.rate_hz.value_or(header_.rate_hz);
  if (options.rate_hz && !(rate_hz > 0 && std::isfinite(rate_hz))) {
    throw UserError(info_.path.string(), fmt::format("the rate given is {} Hz", rate_hz), "give a rate above 0 Hz");
  }
  scan_rows(rate_hz);
  if (const auto problems = problems_of(info_.markers); !problems.empty()) {
    throw UserError(info_.path.string(), problems.front(), "correct the header or the take's options");
  }
  rewind();
}

/// Counts the frames and, if the rate is not known, measures it over the first and last time.
void RowTakeReader::scan_rows(double rate_hz) {
  std::uint64_t frames = 0, last_frame = 0;
  std::size_t widest = 0;
  double first_s = 0, last_s = 0;
  const bool is_timed = !(rate_hz > 0);
  while (next_row()) {
    const std::uint64_t number = frame_number();
    if (frames == 0) first_frame_ = number;
    if (frames > 0 && number <= last_frame) {
      throw UserError(place(), fmt::format("frame {} does not come after frame {}", number, last_frame),
                      "sort the lines by frame, and remove duplicates");
    }
    if (frames > 0 && number - last_frame > kLongestLeap) {
      throw UserError(
          place(), fmt::format("the frame numbers leap from {} to {}", last_frame, number),
          fmt::format("correct the number, or cut the take in two: at most {} lost frames in a row are read",
                      kLongestLeap));
    }
    last_frame = number;
    widest = std::max(widest, cells_.size());
    if (is_timed) {
      if (cells_.size() <= kTimeCell) throw UserError(place(), "the line has no time", "export the take again");
      last_s = number_at(kTimeCell);
      if (frames == 0) first_s = last_s;
    }
    ++frames;
  }
  if (frames == 0) throw UserError(info_.path.string(), "no frames after the header", "export the take again");
  if (info_.frame_count && *info_.frame_count != frames) {
    info_.warnings.push_back(fmt::format("the header says {} frames, the file has {}", *info_.frame_count, frames));
  }
  info_.frame_count = frames;
  if (header_.has_unnamed_cells && widest > header_.row_cells) {
    info_.warnings.push_back(fmt::format("markers without a name, left out: {} cells beyond those of the {} named ones",
                                         widest - header_.row_cells, info_.markers.names.size()));
  }
  if (is_timed) {
    rate_hz = static_cast<double>(last_frame - first_frame_) / (last_s - first_s);
    if (!(rate_hz > 0 && std::isfinite(rate_hz))) {
      throw UserError(info_.path.string(), "neither the header nor the times tell a rate", "give the rate of the take");
    }
    if (std::abs(rate_hz - std::round(rate_hz)) < kWholeRate * rate_hz) rate_hz = std::round(rate_hz);
  }
  info_.markers.rate_hz = rate_hz;
}

std::uint64_t RowTakeReader::frame_number() const {
  const double number = number_at(kFrameCell);
  if (!(number >= 0 && number < 1e15) || number != std::floor(number)) {
    throw UserError(place(), fmt::format("'{}' is no frame number", shown(cells_[kFrameCell])),
                    "the first cell of a line is the number of the frame");
  }
  return static_cast<std::uint64_t>(number);
}

double RowTakeReader::number_at(std::size_t cell) const {
  const auto value = parse_double(cells_[cell]);
  if (!value || std::isinf(*value)) {
    throw UserError(fmt::format("{}, cell {}", place(), cell + 1),
                    fmt::format("'{}' is no number", shown(cells_[cell])), "write a number with a decimal point");
  }
  return *value;
}

/// A marker is missing where its cells are empty, beyond the end of the line, NaN, or all three exactly 0.
void RowTakeReader::read_marker(std::size_t marker, MarkerFrame& frame) const {
  std::array<double, 3> value{};
  int empty = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t cell = header_.first_cells[marker] + axis;
    if (cell >= cells_.size() || cells_[cell].empty()) {
      ++empty;
    } else {
      value[axis] = number_at(cell);
    }
  }
  if (empty == 3) return;
  if (empty > 0) {
    throw UserError(place(),
                    fmt::format("marker {} has {} of 3 coordinates", shown(info_.markers.names[marker]), 3 - empty),
                    "the line is cut short, or a cell was lost");
  }
  const bool is_zero = value[0] == 0 && value[1] == 0 && value[2] == 0;
  if (is_zero || std::isnan(value[0]) || std::isnan(value[1]) || std::isnan(value[2])) return;
  const double scale = info_.markers.mm_per_unit;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(value[axis] * scale) <= kFarthestMm) continue;
    throw UserError(fmt::format("{}, cell {}", place(), header_.first_cells[marker] + axis + 1),
                    fmt::format("'{}' puts marker {} more than a kilometre away",
                                shown(cells_[header_.first_cells[marker] + axis]), shown(info_.markers.names[marker])),
                    "correct the number, or the unit (--units)");
  }
  frame.state[marker] = MarkerState::kMeasured;
  frame.position_mm[marker] = info_.markers.axes.to_world(
      static_cast<float>(value[0] * scale), static_cast<float>(value[1] * scale), static_cast<float>(value[2] * scale));
}

bool RowTakeReader::next(MarkerFrame& frame) {
  if (!next_row()) return false;
  if (cells_.size() > header_.row_cells && !header_.has_unnamed_cells) {
    throw UserError(place(), fmt::format("{} cells where the header has {}", cells_.size(), header_.row_cells),
                    "the header and the lines must agree");
  }
  frame = MarkerFrame();
  frame.header.sequence = frame_number() - first_frame_;
  if (last_sequence_ && frame.header.sequence <= *last_sequence_) {
    throw UserError(place(), "the file changed while it was read", "wait until it is complete");
  }
  last_sequence_ = frame.header.sequence;
  frame.header.capture_time_ns = capture_time_of(frame.header.sequence, info_.markers.rate_hz);
  frame.count = static_cast<std::uint32_t>(header_.first_cells.size());
  for (std::size_t marker = 0; marker < header_.first_cells.size(); ++marker) read_marker(marker, frame);
  return true;
}

void RowTakeReader::rewind() {
  file_.clear();
  file_.seekg(rows_begin_);
  line_number_ = rows_begin_line_;
  last_sequence_.reset();
}

}  // namespace risorius
