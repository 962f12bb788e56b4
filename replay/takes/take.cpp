#include "replay/takes/take.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "capture/errors.h"
#include "replay/takes/bnd_reader.h"
#include "replay/takes/c3d_reader.h"
#include "replay/takes/csv_take.h"
#include "replay/takes/iemocap_reader.h"
#include "replay/takes/kinect_text_reader.h"
#include "replay/takes/trc_reader.h"

namespace risorius {
namespace {

__extension__ using WideUnsigned = unsigned __int128;

constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;

struct RationalRate {
  std::uint64_t numerator = 0, denominator = 0;  ///< frames per seconds; denominator 0: the rate is not such a number
};

/// Files keep rates as float: 119.88 arrives as 119.87999725. A rate within float rounding of a whole number, of a
/// decimal fraction or of a broadcast rate (n * 1000 / 1001) is meant to be that number, and time then never drifts.
RationalRate rational_of(double rate_hz) noexcept {
  constexpr double kFloatRounding = 6e-8;  // 2^-24
  constexpr double kExactBelow = 1e12;
  for (const std::uint64_t denominator : std::array<std::uint64_t, 5>{1, 10, 100, 1001, 1000}) {
    const double scaled = rate_hz * static_cast<double>(denominator);
    if (!(scaled >= 0.5 && scaled < kExactBelow)) continue;
    double whole = std::round(scaled);
    if (denominator == 1001) whole = std::round(scaled / 1000) * 1000;
    if (whole > 0 && std::abs(scaled - whole) <= kFloatRounding * scaled)
      return {static_cast<std::uint64_t>(whole), denominator};
  }
  return {};
}

std::uint64_t parse_frame_index(std::string_view digits, std::string_view whole_text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size())
    throw UserError(std::string(whole_text), "the frame index '" + std::string(digits) + "' is not a number from 0",
                    "write PATH:FROM-TO, such as take.c3d:20-90");
  return value;
}

}  // namespace

std::unique_ptr<TakeReader> open_take(const std::filesystem::path& path, const TakeOptions& options) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  if (extension == ".c3d") return std::make_unique<C3dReader>(path, options);
  if (extension == ".csv") return std::make_unique<CsvTakeReader>(path, options);
  if (extension == ".trc") return std::make_unique<TrcReader>(path, options);
  if (extension == ".txt" && KinectTextReader::knows(path)) return std::make_unique<KinectTextReader>(path, options);
  if (extension == ".txt") return std::make_unique<IemocapReader>(path, options);
  if (extension == ".bnd" || std::filesystem::is_directory(path)) return std::make_unique<BndReader>(path, options);
  throw UserError(path.string(), "the extension '" + extension + "' is no take format that is known here",
                  "give a .c3d, .csv, .trc, .txt (IEMOCAP, Kinect) or .bnd file, or a folder of .bnd files (BU-4DFE)");
}

TakeRange parse_take_range(std::string_view text) {
  TakeRange range{.path = std::string(text), .first = {}, .last = {}};
  const std::size_t colon = text.rfind(':');
  const std::string_view frames = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  // Only what looks like frames is taken for frames: a colon is legitimate in a file's name.
  if (colon != std::string_view::npos && frames.find_first_not_of("0123456789-") == std::string_view::npos) {
    const std::size_t dash = frames.find('-');
    if (dash == std::string_view::npos)
      throw UserError(std::string(text), "'" + std::string(frames) + "' is not a range of frames",
                      "write PATH:FROM-TO, such as take.c3d:20-90");
    range.path = std::string(text.substr(0, colon));
    range.first = parse_frame_index(frames.substr(0, dash), text);
    range.last = parse_frame_index(frames.substr(dash + 1), text);
    if (*range.first > *range.last)
      throw UserError(std::string(text), "the range ends before it begins", "write PATH:FROM-TO with FROM <= TO");
  }
  if (range.path.empty()) throw UserError("take '" + std::string(text) + "'", "no path", "write PATH or PATH:FROM-TO");
  return range;
}

std::int64_t capture_time_of(std::uint64_t index, double rate_hz) noexcept {
  constexpr auto kLatest = std::numeric_limits<std::int64_t>::max();
  const RationalRate rate = rational_of(rate_hz);
  if (rate.denominator == 0) {
    // The 64-bit mantissa of long double holds index * 1e9 exactly for 2^34 frames and keeps the order of all.
    const long double time_ns = static_cast<long double>(index) * kNanosecondsPerSecond / rate_hz;
    return time_ns < static_cast<long double>(kLatest) ? std::llroundl(time_ns) : kLatest;
  }
  const WideUnsigned scaled = static_cast<WideUnsigned>(index) * kNanosecondsPerSecond * rate.denominator;
  const WideUnsigned time_ns = (2 * scaled + rate.numerator) / (2 * static_cast<WideUnsigned>(rate.numerator));
  return time_ns < static_cast<WideUnsigned>(kLatest) ? static_cast<std::int64_t>(time_ns) : kLatest;
}

}  // namespace risorius
