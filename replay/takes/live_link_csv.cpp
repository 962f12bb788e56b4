#include "replay/takes/live_link_csv.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <unordered_set>

#include "capture/errors.h"
#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

constexpr std::array kBases{24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 100.0, 120.0, 240.0};
constexpr double kDayS = 86400;
constexpr std::size_t kRotations = 9;  // head and eyes: radians, at the end of the header

struct Timecode {
  double seconds = 0;  ///< whole seconds since midnight
  double frames = 0;   ///< FF.sss
};

std::optional<Timecode> parse_timecode(std::string_view text) {
  std::array<std::string_view, 4> part;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t colon = i < 3 ? text.find(':') : text.size();
    if (colon == std::string_view::npos) return std::nullopt;
    part[i] = text.substr(0, colon);
    text.remove_prefix(std::min(colon + 1, text.size()));
  }
  std::array<double, 3> clock{};
  for (std::size_t i = 0; i < 3; ++i) {
    int number = 0;
    const auto [end, error] = std::from_chars(part[i].data(), part[i].data() + part[i].size(), number);
    if (error != std::errc() || end != part[i].data() + part[i].size() || number < 0 || number > 59)
      return std::nullopt;
    clock[i] = number;
  }
  const auto frames = parse_double(part[3]);
  if (!frames || !(*frames >= 0 && *frames < kBases.back())) return std::nullopt;
  return Timecode{3600 * clock[0] + 60 * clock[1] + clock[2], *frames};
}

/// Steps between frames in units of 1 / base seconds. A day's end is a step, too.
std::vector<double> steps_in(const std::vector<Timecode>& codes, double base) {
  std::vector<double> steps;
  for (std::size_t i = 0; i + 1 < codes.size(); ++i) {
    double seconds = codes[i + 1].seconds - codes[i].seconds;
    if (seconds < -kDayS / 2) seconds += kDayS;
    steps.push_back(seconds * base + codes[i + 1].frames - codes[i].frames);
  }
  return steps;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The base that the frames count in, and a frame's usual step in it.
struct Clock {
  double base = 0, step = 0;
  double rate_hz() const { return base / step; }
};

/// In the true base nearly all steps are equal; in another one the steps over the second's end are not.
std::optional<Clock> infer_clock(const std::vector<Timecode>& codes) {
  const bool sees_a_second_end = std::any_of(
      codes.begin(), codes.end(), [&](const Timecode& code) { return code.seconds != codes.front().seconds; });
  if (!sees_a_second_end) return std::nullopt;
  const double highest =
      std::max_element(codes.begin(), codes.end(), [](auto& a, auto& b) { return a.frames < b.frames; })->frames;
  std::optional<Clock> best;
  std::size_t most_equal = 0;
  for (const double base : kBases) {
    if (highest >= base) continue;
    const std::vector<double> steps = steps_in(codes, base);
    const double usual = median_of(steps);
    if (usual <= 0) continue;
    const auto equal = static_cast<std::size_t>(
        std::count_if(steps.begin(), steps.end(), [&](double s) { return std::abs(s - usual) < 0.25 * usual; }));
    if (equal <= most_equal) continue;
    most_equal = equal;
    const double whole = std::round(usual);
    best = Clock{base, whole >= 1 && std::abs(usual - whole) < 0.05 * whole ? whole : usual};
  }
  return best;
}

bool is_rotation(const std::string& name) {
  return name.ends_with("Yaw") || name.ends_with("Pitch") || name.ends_with("Roll");
}

double value_at(const CsvFile& file, std::size_t column) {
  if (file.cell(column).empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto value = parse_double(file.cell(column));
  if (!value) file.fail_at(column, "write a number with a decimal point, or leave it empty");
  if (*value < kLeastIntensity || *value > kMostIntensity)
    file.fail_at(column,
                 fmt::format("a shape's value is about 0 to 1 (accepted: {} to {})", kLeastIntensity, kMostIntensity));
  return *value;
}

/// Nothing is solved from them: they are handed on.
float angle_at(const CsvFile& file, std::size_t column) {
  if (file.cell(column).empty()) return 0;
  const auto value = parse_double(file.cell(column));
  if (!value) file.fail_at(column, "write a number with a decimal point, or leave it empty");
  return static_cast<float>(*value);
}

/// Beyond this a leap is a wrong timecode, not a loss: a quarter of an hour at 60 Hz.
constexpr std::uint64_t kLongestLeap = 54'000;

/// Each frame so many numbers after the one before as the clock's steps fit between them: uneven steps that add up to a
/// place beyond the next one are no hole.
void number_frames(const std::vector<Timecode>& codes, const Clock& clock, const std::vector<std::string>& places,
                   LiveLinkTake& take) {
  const std::vector<double> steps = steps_in(codes, clock.base);
  std::uint64_t holes = 0, lost = 0, frame = 0;
  take.shapes.frames.push_back(0);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] <= 0)
      throw UserError(places[i + 1], "the timecode does not grow", "is the file complete and in its order?");
    const auto next = frame + static_cast<std::uint64_t>(std::max(1LL, std::llround(steps[i] / clock.step)));
    if (next > frame + 1) {
      if (next - frame > kLongestLeap) {
        throw UserError(places[i + 1], fmt::format("the timecode leaps by {} frames", next - frame),
                        "correct the timecode, or cut the recording in two");
      }
      ++holes;
      lost += next - frame - 1;
    }
    frame = next;
    take.shapes.frames.push_back(frame);
  }
  if (holes > 0) take.warnings.push_back(fmt::format("{} holes, {} frames lost", holes, lost));
}

}  // namespace

std::string arkit_name(std::string column) {
  if (!column.empty()) column[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(column[0])));
  return column;
}

bool is_live_link_csv(const std::filesystem::path& path) { return CsvFile(path).columns().front() == "Timecode"; }

LiveLinkTake load_live_link_csv(const std::filesystem::path& path, std::optional<double> rate_hz) {
  CsvFile file(path);
  const std::vector<std::string>& columns = file.columns();
  const std::string header_place = path.string() + ", line 1";
  // The app has written both BlendShapeCount and BlendshapeCount.
  const bool good_header = columns.size() > 2 && columns[0] == "Timecode" &&
                           (columns[1] == "BlendShapeCount" || columns[1] == "BlendshapeCount");
  if (!good_header)
    throw UserError(header_place, "not the header of Live Link Face",
                    "it begins with Timecode,BlendShapeCount,EyeBlinkLeft,...");
  LiveLinkTake take;
  std::vector<std::size_t> shape_columns;
  std::array<std::size_t, kLiveLinkAngles.size()> angle_columns{};  // 0: there is none
  std::unordered_set<std::string> seen;
  for (std::size_t column = 2; column < columns.size(); ++column) {
    const std::string name = arkit_name(columns[column]);
    if (name.empty() || !seen.insert(name).second)
      throw UserError(header_place, "column '" + columns[column] + "' has no name or stands twice",
                      "name each shape once");
    if (const auto angle = std::ranges::find(kLiveLinkAngles, name); angle != kLiveLinkAngles.end())
      angle_columns[static_cast<std::size_t>(angle - kLiveLinkAngles.begin())] = column;
    if (is_rotation(name) && column + kRotations >= columns.size()) continue;
    take.shapes.names.push_back(name);
    shape_columns.push_back(column);
  }
  std::vector<Timecode> codes;
  std::vector<std::string> places;
  while (file.next_row()) {
    const auto code = parse_timecode(file.cell(0));
    if (!code) file.fail_at(0, "a timecode is HH:MM:SS:FF or HH:MM:SS:FF.sss");
    codes.push_back(*code);
    places.push_back(file.place());
    auto& row = take.shapes.intensities.emplace_back();
    row.reserve(shape_columns.size());
    for (const std::size_t column : shape_columns) row.push_back(value_at(file, column));
    auto& angles = take.angles.emplace_back();
    for (std::size_t i = 0; i < angles.size(); ++i) {
      if (angle_columns[i] != 0) angles[i] = angle_at(file, angle_columns[i]);
    }
  }
  if (codes.empty()) throw UserError(path.string(), "has no frames", "give a recording with frames");
  const auto clock = infer_clock(codes);
  if (!clock && !rate_hz)
    throw UserError(path.string(), "the timecodes do not say the rate: they reach over no second's end",
                    "give the rate (--rate, or --au-rate of risorius perform)");
  if (clock) {
    number_frames(codes, *clock, places, take);
  } else {
    for (std::size_t i = 0; i < codes.size(); ++i) take.shapes.frames.push_back(i);
  }
  take.rate_hz = rate_hz ? *rate_hz : clock->rate_hz();
  return take;
}

}  // namespace risorius
