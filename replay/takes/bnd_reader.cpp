#include "replay/takes/bnd_reader.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <optional>
#include <sstream>

#include "capture/errors.h"
#include "capture/plausible_position.h"
#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

/// "M2_7" before "M2_10": runs of digits compare as numbers.
bool comes_before(const std::filesystem::path& left_path, const std::filesystem::path& right_path) {
  const std::string left = left_path.filename().string(), right = right_path.filename().string();
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t i = 0, j = 0;
  while (i < left.size() && j < right.size()) {
    if (!is_digit(left[i]) || !is_digit(right[j])) {
      if (left[i] != right[j]) return left[i] < right[j];
      ++i, ++j;
      continue;
    }
    while (i < left.size() && left[i] == '0') ++i;
    while (j < right.size() && right[j] == '0') ++j;
    const std::size_t i_begin = i, j_begin = j;
    while (i < left.size() && is_digit(left[i])) ++i;
    while (j < right.size() && is_digit(right[j])) ++j;
    if (i - i_begin != j - j_begin) return i - i_begin < j - j_begin;
    const int order = left.compare(i_begin, i - i_begin, right, j_begin, j - j_begin);
    if (order != 0) return order < 0;
  }
  return left.size() - i < right.size() - j;
}

std::vector<std::filesystem::path> files_of(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() == ".bnd") files.push_back(entry.path());
  }
  if (files.empty()) {
    throw UserError(path.string(), "the folder holds no .bnd files", "give a take, or a folder of BU-4DFE landmarks");
  }
  std::ranges::sort(files, comes_before);
  return files;
}

/// The last number in the file's name.
std::optional<std::uint64_t> number_of(const std::filesystem::path& path) {
  const std::string name = path.stem().string();
  const std::size_t last = name.find_last_of("0123456789");
  if (last == std::string::npos) return {};
  const std::size_t before = name.find_last_not_of("0123456789", last);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + begin, name.data() + last + 1, number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

/// From 0, as the files are numbered: a number that lacks is a lost frame. Files without numbers follow each other.
std::vector<std::uint64_t> sequence_of(const std::vector<std::filesystem::path>& files) {
  std::vector<std::uint64_t> sequence{0};
  for (std::size_t i = 1; i < files.size(); ++i) {
    const auto before = number_of(files[i - 1]), number = number_of(files[i]);
    if (!before || !number) {
      sequence.push_back(sequence.back() + 1);
      continue;
    }
    const std::string place = files[i].string();
    if (*number <= *before) {
      throw UserError(place, fmt::format("has the number {} after {}", *number, files[i - 1].filename().string()),
                      "number the files of a take once each; keep other takes in folders of their own");
    }
    if (*number - *before > kLongestLeap) {
      throw UserError(place, fmt::format("the numbers leap from {} to {}", *before, *number),
                      fmt::format("at most {} lost frames in a row are read", kLongestLeap));
    }
    sequence.push_back(sequence.back() + *number - *before);
  }
  return sequence;
}

}  // namespace

BndReader::BndReader(const std::filesystem::path& path, const TakeOptions& options)
    : files_(files_of(path)), sequence_(sequence_of(files_)) {
  info_.path = path;
  info_.markers.mm_per_unit = options.mm_per_unit.value_or(1);
  info_.markers.axes = options.axes.value_or(Axes());
  info_.markers.rate_hz = options.rate_hz.value_or(kRateHz);
  info_.frame_count = files_.size();
  if (!options.rate_hz) {
    info_.warnings.push_back(fmt::format("the files state no rate: {:g} Hz, as BU-4DFE was filmed", kRateHz));
  }
  for (const Landmark& landmark : read_landmarks(files_.front())) {
    indices_.push_back(landmark.index);
    info_.markers.names.push_back(fmt::format("L{:02}", landmark.index));
  }
  if (const auto problems = problems_of(info_.markers); !problems.empty()) {
    throw UserError(files_.front().string(), problems.front(), "correct the file or the take's options");
  }
}

std::vector<BndReader::Landmark> BndReader::read_landmarks(const std::filesystem::path& file) {
  std::ifstream text(file);
  if (!text) throw UserError(file.string(), "cannot be opened", "check the path and its permissions");
  std::vector<Landmark> landmarks;
  std::string line;
  for (int line_number = 1; std::getline(text, line); ++line_number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    std::string word;
    std::vector<double> values;
    while (words >> word) values.push_back(parse_double(word).value_or(INFINITY));
    const bool is_landmark = values.size() == 4 && std::ranges::none_of(values, [](double v) { return std::isinf(v); });
    if (!is_landmark || values[0] != std::floor(values[0]) || !(values[0] >= 0 && values[0] < 10'000)) {
      throw UserError(fmt::format("{}, line {}", file.string(), line_number),
                      fmt::format("'{}' is no landmark", shown(line)), "each line holds index, x, y and z");
    }
    landmarks.push_back({static_cast<int>(values[0]), values[1], values[2], values[3]});
  }
  if (landmarks.empty()) throw UserError(file.string(), "no landmarks in it", "leave the file out, or mend it");
  return landmarks;
}

bool BndReader::next(MarkerFrame& frame) {
  if (next_ == files_.size()) return false;
  const std::vector<Landmark> landmarks = read_landmarks(files_[next_]);
  if (landmarks.size() != indices_.size()) {
    throw UserError(files_[next_].string(),
                    fmt::format("{} landmarks where the first file has {}", landmarks.size(), indices_.size()),
                    "all files of a take have the same landmarks");
  }
  frame = MarkerFrame();
  frame.header.sequence = sequence_[next_];
  frame.header.capture_time_ns = capture_time_of(sequence_[next_], info_.markers.rate_hz);
  frame.count = static_cast<std::uint32_t>(indices_.size());
  const double scale = info_.markers.mm_per_unit;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Landmark& landmark = landmarks[i];
    if (landmark.index != indices_[i]) {
      throw UserError(files_[next_].string(),
                      fmt::format("landmark {} stands where the first file has {}", landmark.index, indices_[i]),
                      "all files of a take have the same landmarks in the same order");
    }
    if (std::isnan(landmark.x) || std::isnan(landmark.y) || std::isnan(landmark.z)) continue;
    for (const double value : {landmark.x, landmark.y, landmark.z}) {
      if (std::abs(value * scale) <= kFarthestMm) continue;
      throw UserError(fmt::format("{}, landmark {}", files_[next_].string(), landmark.index),
                      fmt::format("{} is more than a kilometre away", value),
                      "correct the number, or the unit (--units)");
    }
    frame.state[i] = MarkerState::kMeasured;
    frame.position_mm[i] =
        info_.markers.axes.to_world(static_cast<float>(landmark.x * scale), static_cast<float>(landmark.y * scale),
                                    static_cast<float>(landmark.z * scale));
  }
  ++next_;
  return true;
}

}  // namespace risorius
