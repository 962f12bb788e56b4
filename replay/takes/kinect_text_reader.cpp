#include "replay/takes/kinect_text_reader.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>

#include "capture/errors.h"
#include "capture/plausible_position.h"

namespace risorius {
namespace {

constexpr std::string_view kBegin = "0.0 0x 0y 0z";
/// Of the first Kinect's colour camera, nominal (Khoshelham & Elberink 2012 measured 525 to 530 px).
constexpr double kFocalLengthPx = 525, kCentreXPx = 320, kCentreYPx = 240;
constexpr std::int64_t kNsPerMs = 1'000'000;

/// The whole text as digits.
std::optional<std::int64_t> digits_of(std::string_view text) noexcept {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return {};
  return value;
}

}  // namespace

bool KinectTextReader::knows(const std::filesystem::path& path) {
  std::array<char, kBegin.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), begin.size()) && std::string_view(begin.data(), begin.size()) == kBegin;
}

KinectTextReader::KinectTextReader(const std::filesystem::path& path, const TakeOptions& options) : file_(path) {
  info_.path = path;
  info_.markers.axes = options.axes.value_or(Axes());
  if (options.mm_per_unit && *options.mm_per_unit != 1) {
    throw UserError(path.string(), "the points are pixels with a depth in mm", "leave out --units");
  }
  name_points();
  std::int64_t last_ns = 0;
  std::uint64_t frames = 0;
  for (; file_.next_row(); ++frames) {
    const std::int64_t time_ns = read_time_ns();
    if (frames == 0) begin_ns_ = time_ns;
    if (frames > 0 && time_ns <= last_ns) {
      file_.fail_at(0, fmt::format("{} s does not come after the line before", shown(file_.cell(0))),
                    "sort the lines by time (the part behind the point is milliseconds), and remove duplicates");
    }
    last_ns = time_ns;
  }
  if (frames < 2)
    throw UserError(path.string(), fmt::format("{} frames after the header", frames), "give a whole take");
  info_.frame_count = frames;
  info_.markers.rate_hz =
      options.rate_hz.value_or(static_cast<double>(frames - 1) / (static_cast<double>(last_ns - begin_ns_) * 1e-9));
  is_retimed_ = options.rate_hz.has_value();
  info_.warnings.push_back(fmt::format(
      "points carried into mm with a focal length of {} px, sides as the file calls them; {:.2f} frames a second{}",
      kFocalLengthPx, info_.markers.rate_hz,
      is_retimed_ ? ", as was given" : " in the mean, at irregular times (CSV keeps them, C3D has a rate only)"));
  if (const auto problems = problems_of(info_.markers); !problems.empty()) {
    throw UserError(path.string(), problems.front(), "correct the header or the take's options");
  }
  rewind();
}

void KinectTextReader::name_points() {
  const auto& columns = file_.columns();
  for (std::size_t column = 1; column < columns.size(); column += 3) {
    const std::size_t point = info_.markers.names.size();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string wanted = fmt::format("{}{}", point, "xyz"[axis]);
      if (column + axis < columns.size() && columns[column + axis] == wanted) continue;
      throw UserError(file_.place(), fmt::format("column {} is not {}", column + axis + 1, wanted),
                      "the header must be 0.0 0x 0y 0z 1x 1y 1z and so on");
    }
    info_.markers.names.push_back(fmt::format("P{}", point));
  }
}

std::int64_t KinectTextReader::read_time_ns() const {
  const std::string_view text = file_.cell(0);
  const std::size_t point = text.find('.');
  constexpr std::size_t kMostMsDigits = 3;
  const auto seconds = digits_of(text.substr(0, point));
  const std::string_view behind = point == std::string_view::npos ? "0" : text.substr(point + 1);
  const auto ms = digits_of(behind);
  if (!seconds || !ms || behind.size() > kMostMsDigits || *seconds > INT64_MAX / 1'000'000'000 - 1) {
    file_.fail_at(0, fmt::format("'{}' is no time", shown(text)),
                  "write seconds, a point, and up to three digits of milliseconds");
  }
  return *seconds * 1'000'000'000 + *ms * kNsPerMs;
}

double KinectTextReader::read_number(std::size_t column) const {
  const auto value = parse_double(file_.cell(column));
  if (!value || !std::isfinite(*value)) file_.fail_at(column, "write a number with a decimal point");
  return *value;
}

bool KinectTextReader::next(MarkerFrame& frame) {
  if (!file_.next_row()) return false;
  frame = MarkerFrame();
  frame.header.sequence = next_index_++;
  frame.header.capture_time_ns =
      is_retimed_ ? capture_time_of(frame.header.sequence, info_.markers.rate_hz) : read_time_ns() - begin_ns_;
  frame.count = static_cast<std::uint32_t>(info_.markers.names.size());
  for (std::size_t i = 0; i < frame.count; ++i) {
    const double u = read_number(3 * i + 1), v = read_number(3 * i + 2), depth_mm = read_number(3 * i + 3);
    if (!(depth_mm > 0)) continue;
    // The picture is mirrored, as the tracker's is: what it calls left stands at small x.
    const auto x = static_cast<float>((kCentreXPx - u) * depth_mm / kFocalLengthPx);
    const auto y = static_cast<float>((kCentreYPx - v) * depth_mm / kFocalLengthPx);
    const auto z = static_cast<float>(-depth_mm);
    if (!is_plausible_position(x, y, z)) {
      file_.fail_at(3 * i + 3, fmt::format("P{} would be more than a kilometre away", i), "correct the line");
    }
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] = info_.markers.axes.to_world(x, y, z);
  }
  return true;
}

void KinectTextReader::rewind() {
  file_.rewind();
  next_index_ = 0;
}

}  // namespace risorius
