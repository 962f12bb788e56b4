#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <unordered_map>
#include <utility>

#include "capture/errors.h"
#include "capture/plausible_position.h"
#include "replay/takes/csv_take.h"
#include "replay/takes/take_names.h"

namespace risorius {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;
/// Times are often written with six digits, so each may be off by half a microsecond, and by as much at the start.
constexpr std::int64_t kPrintedTimeError_ns = 1'001;

/// The grid that all times lie on: time = start + (start_index + number) / rate, frames numbered from 0.
struct TimeGrid {
  double rate_hz = 0;
  std::int64_t start_time_ns = 0;
  std::uint64_t start_index = 0;
};

bool lies_on(const CsvTakeTimes& times, const TimeGrid& grid) {
  const auto& times_ns = times.times_ns;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    const std::int64_t expected =
        grid.start_time_ns + capture_time_of(grid.start_index + times.number_of(i), grid.rate_hz);
    if (std::abs(times_ns[i] - expected) > kPrintedTimeError_ns) return false;
  }
  return true;
}

TimeGrid grid_from(std::int64_t first_ns, double rate_hz) {
  TimeGrid grid{.rate_hz = rate_hz};
  // A part of a take keeps its place on the take's grid, so that its times keep their bits.
  const double index = std::round(static_cast<double>(first_ns) / kNanosecondsPerSecond * rate_hz);
  if (index >= 0 && index < 1e15) grid.start_index = static_cast<std::uint64_t>(index);
  if (std::abs(capture_time_of(grid.start_index, rate_hz) - first_ns) <= kPrintedTimeError_ns) return grid;
  return {.rate_hz = rate_hz, .start_time_ns = first_ns};
}

/// At least two times, growing. Empty if the steps are not equal.
std::optional<TimeGrid> find_grid(const CsvTakeTimes& times) {
  const auto& times_ns = times.times_ns;
  const double mean_step_s = static_cast<double>(times_ns.back() - times_ns.front()) / kNanosecondsPerSecond /
                             static_cast<double>(times.number_of(times_ns.size() - 1));
  const double rate = 1 / mean_step_s;
  // The rate was a simple number before it was printed as times.
  for (const double candidate :
       {std::round(rate), std::round(rate) * 1000 / 1001, std::round(rate * 100) / 100, rate}) {
    if (!(candidate > 0) || !std::isfinite(candidate)) continue;
    const TimeGrid grid = grid_from(times_ns.front(), candidate);
    if (lies_on(times, grid)) return grid;
  }
  return {};
}

double median_step_rate_hz(const CsvTakeTimes& times) {
  std::vector<double> steps(times.times_ns.size() - 1);
  for (std::size_t i = 0; i + 1 < times.times_ns.size(); ++i) {
    steps[i] = static_cast<double>(times.times_ns[i + 1] - times.times_ns[i]) /
               static_cast<double>(times.number_of(i + 1) - times.number_of(i));
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return kNanosecondsPerSecond / *middle;
}

constexpr std::size_t kNoColumn = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kNoAxis = 3;
constexpr std::string_view kAxisLetters = "xyz";

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

/// 0 to 2 for "NAME_x" to "NAME_z".
std::size_t axis_of(const std::string& title) {
  if (title.size() < 3 || title[title.size() - 2] != '_') return kNoAxis;
  return std::min(kAxisLetters.find(lower(title).back()), kNoAxis);
}

}  // namespace

CsvTakeReader::CsvTakeReader(const std::filesystem::path& path, const TakeOptions& options) : file_(path) {
  info_.path = path;
  info_.markers.mm_per_unit = options.mm_per_unit.value_or(1);
  info_.markers.axes = options.axes.value_or(Axes());
  assign_columns();
  settle_times(scan_times(), options.rate_hz);
  const auto problems = problems_of(info_.markers);
  if (!problems.empty()) throw UserError(path.string(), problems.front(), "correct the header or the take's options");
  rewind();
}

void CsvTakeReader::assign_columns() {
  std::unordered_map<std::string, std::size_t> index_of;
  for (std::size_t column = 0; column < file_.columns().size(); ++column) {
    const std::string& title = file_.columns()[column];
    const std::size_t axis = axis_of(title);
    if (lower(title) == "frame") {
      frame_column_ = column;
      continue;
    }
    if (lower(title) == "time_s") {
      if (time_column_) fail_in_header(title, "stands twice", "keep one");
      time_column_ = column;
    } else if (axis == kNoAxis) {
      info_.warnings.push_back("column '" + title + "' is neither frame, time_s nor NAME_x, NAME_y, NAME_z: ignored");
    } else {
      const std::string name = title.substr(0, title.size() - 2);
      const auto [entry, is_new] = index_of.emplace(name, columns_of_marker_.size());
      if (is_new) {
        columns_of_marker_.push_back({kNoColumn, kNoColumn, kNoColumn});
        info_.markers.names.push_back(marker_name_of(name, info_));
      }
      std::size_t& place = columns_of_marker_[entry->second][axis];
      if (place != kNoColumn) fail_in_header(title, "stands twice", "give each marker a name of its own");
      place = column;
    }
  }
  check_columns();
}

void CsvTakeReader::check_columns() const {
  if (columns_of_marker_.empty())
    throw UserError(info_.path.string() + ", line 1", "no column is named like NAME_x, NAME_y, NAME_z",
                    "the first line must be frame,time_s,NAME_x,NAME_y,NAME_z,...");
  for (std::size_t i = 0; i < columns_of_marker_.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (columns_of_marker_[i][axis] == kNoColumn)
        fail_in_header(info_.markers.names[i] + "_" + kAxisLetters[axis], "is missing",
                       "each marker needs the columns _x, _y and _z");
}

void CsvTakeReader::fail_in_header(const std::string& column, const std::string& problem,
                                   const std::string& remedy) const {
  throw UserError(info_.path.string() + ", line 1, column " + column, problem, remedy);
}

/// Frame numbers that leap are lost frames.
std::uint64_t CsvTakeReader::read_frame_number(const std::optional<std::uint64_t>& last) const {
  const std::string_view cell = file_.cell(*frame_column_);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || end != cell.data() + cell.size() || number > std::uint64_t{1} << 53U) {
    file_.fail_at(*frame_column_, fmt::format("'{}' is no frame number", shown(cell)),
                  "number the frames from 0, in whole numbers");
  }
  if (last && number <= *last) {
    file_.fail_at(*frame_column_, fmt::format("frame {} does not come after frame {}", number, *last),
                  "sort the lines by frame, and remove duplicates");
  }
  if (last && number - *last > kLongestLeap) {
    file_.fail_at(*frame_column_, fmt::format("the frame numbers leap from {} to {}", *last, number),
                  fmt::format("correct the number, or cut the take in two: at most {} lost frames in a row are read",
                              kLongestLeap));
  }
  return number;
}

CsvTakeTimes CsvTakeReader::scan_times() {
  constexpr double kLatest_s = 9e9;
  CsvTakeTimes times;
  std::vector<std::int64_t>& times_ns = times.times_ns;
  std::uint64_t frames = 0;
  std::optional<std::uint64_t> first_number, last_number;
  file_.rewind();
  for (; file_.next_row(); ++frames) {
    if (frame_column_) {
      last_number = read_frame_number(last_number);
      if (!first_number) first_number = last_number;
      times.numbers.push_back(*last_number - *first_number);
    }
    if (!time_column_) continue;
    const auto time_s = parse_double(file_.cell(*time_column_));
    if (!time_s || !(std::abs(*time_s) < kLatest_s)) file_.fail_at(*time_column_, "give the time in seconds");
    times_ns.push_back(std::llround(*time_s * kNanosecondsPerSecond));
    if (frames > 0 && times_ns.back() <= times_ns[times_ns.size() - 2])
      throw UserError(file_.place() + ", column time_s", fmt::format("{} s is not after the frame before", *time_s),
                      "sort the lines by time, and remove duplicates");
  }
  if (frames == 0) throw UserError(info_.path.string(), "no frames after the header", "export the take again");
  info_.frame_count = frames;
  if (!times.numbers.empty() && times.numbers.back() + 1 == frames) times.numbers.clear();  // none is lost
  return times;
}

void CsvTakeReader::settle_times(CsvTakeTimes times, const std::optional<double>& given_rate_hz) {
  std::vector<std::int64_t>& times_ns = times.times_ns;
  numbers_ = times.numbers;
  if (given_rate_hz) {
    if (!(*given_rate_hz > 0) || !std::isfinite(*given_rate_hz))
      throw UserError(info_.path.string(), fmt::format("the rate given is {} Hz", *given_rate_hz),
                      "give a rate above 0 Hz");
    info_.markers.rate_hz = *given_rate_hz;
    return;
  }
  if (times_ns.size() < 2)
    throw UserError(info_.path.string(), time_column_ ? "one frame has no rate" : "there is no column time_s",
                    "give the rate of the take");
  if (const auto grid = find_grid(times)) {
    info_.markers.rate_hz = grid->rate_hz;
    start_time_ns_ = grid->start_time_ns;
    start_index_ = grid->start_index;
    return;
  }
  info_.markers.rate_hz = median_step_rate_hz(times);
  info_.warnings.push_back(
      fmt::format("the steps of time_s are not equal: the times are kept, the rate is {:.6g} Hz after their median",
                  info_.markers.rate_hz));
  irregular_times_ns_ = std::move(times_ns);
}

bool CsvTakeReader::next(MarkerFrame& frame) {
  if (!file_.next_row()) return false;
  if (next_index_ == *info_.frame_count)
    throw UserError(file_.place(), "the file grew while it was read", "wait until it is complete");
  frame = MarkerFrame();
  frame.header.sequence = number_of(next_index_);
  frame.header.capture_time_ns = capture_time_ns();
  frame.count = static_cast<std::uint32_t>(columns_of_marker_.size());
  for (std::size_t i = 0; i < columns_of_marker_.size(); ++i) {
    const auto& [x, y, z] = columns_of_marker_[i];
    const float x_mm = read_coordinate_mm(x), y_mm = read_coordinate_mm(y), z_mm = read_coordinate_mm(z);
    if (std::isnan(x_mm) || std::isnan(y_mm) || std::isnan(z_mm)) continue;
    for (const auto& [column, value_mm] : {std::pair{x, x_mm}, {y, y_mm}, {z, z_mm}}) {
      if (std::abs(value_mm) <= kFarthestMm) continue;
      file_.fail_at(column, fmt::format("'{}' is more than a kilometre away", shown(file_.cell(column))),
                    "correct the number, or the unit (--units)");
    }
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] = info_.markers.axes.to_world(x_mm, y_mm, z_mm);
  }
  ++next_index_;
  return true;
}

void CsvTakeReader::rewind() {
  file_.rewind();
  next_index_ = 0;
}

float CsvTakeReader::read_coordinate_mm(std::size_t column) const {
  const std::string_view cell = file_.cell(column);
  if (cell.empty()) return std::numeric_limits<float>::quiet_NaN();
  std::optional<float> value_mm;
  if (info_.markers.mm_per_unit == 1) {
    value_mm = parse_float(cell);  // straight to float: rounded once
  } else if (const auto value = parse_double(cell)) {
    value_mm = static_cast<float>(*value * info_.markers.mm_per_unit);
  }
  if (!value_mm || std::isinf(*value_mm))
    file_.fail_at(column, "write a number with a decimal point, or leave it empty");
  return *value_mm;
}

std::int64_t CsvTakeReader::capture_time_ns() const noexcept {
  if (!irregular_times_ns_.empty()) return irregular_times_ns_[next_index_];
  return start_time_ns_ + capture_time_of(start_index_ + number_of(next_index_), info_.markers.rate_hz);
}

}  // namespace risorius
