#include "replay/transitions/pose_argument.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <set>

#include "capture/errors.h"
#include "replay/performer/expression_vector.h"
#include "replay/takes/face_series.h"

namespace risorius {
namespace {

using Eigen::Index;

constexpr double kMostIntensityKept = 1.2;
constexpr double kLeastNoted = 0.02;

/// One end: a series up to or from a frame, or an expression.
struct End {
  std::string argument;
  std::optional<AuSeries> series;
  std::size_t row = 0;                ///< of the series
  std::optional<double> rate_hz;      ///< of the series, where it is known
  std::vector<std::string> warnings;  ///< of its file
};

void load_series(const std::string& path, std::optional<double> rate_hz, End& end) {
  FaceSeries face = load_face_series(path, {.rate_hz = rate_hz});
  end.rate_hz = face.rate_hz;
  end.series = std::move(face.aus);
  for (const std::string& warning : face.warnings) end.warnings.push_back(path + ": " + warning);
}

End end_of_argument(const std::string& argument, bool is_start, std::optional<double> rate_hz = {}) {
  End end{argument, std::nullopt, 0, std::nullopt, {}};
  const std::string path = file_of_end(argument);
  if (path.empty()) {
    const std::string name = argument.substr(0, argument.rfind(':'));
    if (name.ends_with(".csv"))
      throw UserError(name, "is no file", "give an AU series, or an expression: " + expression_names());
    return end;
  }
  load_series(path, rate_hz, end);
  if (path == argument) {
    end.row = is_start ? end.series->frames.size() - 1 : 0;
    return end;
  }
  const std::string_view digits = std::string_view(argument).substr(path.size() + 1);
  std::uint64_t number = 0;
  const auto [last, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const auto& frames = end.series->frames;
  const auto found = std::find(frames.begin(), frames.end(), number);
  if (error != std::errc() || last != digits.data() + digits.size() || found == frames.end()) {
    throw UserError(argument, fmt::format("'{}' is none of its frames", digits),
                    fmt::format("its frames are {} to {}", frames.front(), frames.back()));
  }
  end.row = static_cast<std::size_t>(found - frames.begin());
  return end;
}

/// Values of a row by name; notes what the series lacks or did not observe.
Eigen::RowVectorXf row_of(const End& end, std::size_t row, const std::vector<std::string>& names,
                          std::vector<std::string>* notes) {
  Eigen::RowVectorXf values = Eigen::RowVectorXf::Zero(static_cast<Index>(names.size()));
  std::string lacking, unobserved, cut;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::vector<std::size_t> columns = columns_for(end.series->names, names[k]);
    double sum = 0;
    for (const std::size_t column : columns) sum += end.series->intensities[row][column];
    if (columns.empty()) {
      lacking += " " + names[k];
    } else if (std::isnan(sum)) {
      unobserved += " " + names[k];
    } else {
      const double value = sum / static_cast<double>(columns.size());
      values[static_cast<Index>(k)] = static_cast<float>(std::clamp(value, 0.0, kMostIntensityKept));
      if (value > kMostIntensityKept) cut += fmt::format(" {} {:g}", names[k], value);
    }
  }
  if (notes != nullptr && !lacking.empty()) notes->push_back(end.argument + " has no" + lacking + ": taken as 0");
  if (notes != nullptr && !unobserved.empty())
    notes->push_back(end.argument + " does not observe" + unobserved + " there: taken as 0");
  if (notes != nullptr && !cut.empty())
    notes->push_back(
        fmt::format("{} is above {:g} there, which is the most: cut:{}", end.argument, kMostIntensityKept, cut));
  return values;
}

Eigen::RowVectorXf expression_of(const End& end, const std::vector<std::string>& names,
                                 std::vector<std::string>& notes) {
  const ExpressionVector expression = expression_vector(end.argument, names);
  std::string masked;
  for (const std::string& au : expression.masked) masked += " " + au;
  if (!masked.empty()) notes.push_back(end.argument + " wants" + masked + ", for which there is no column");
  return Eigen::Map<const Eigen::RowVectorXd>(expression.intensities.data(), static_cast<Index>(names.size()))
      .cast<float>();
}

/// The rows up to the start, at the course's rate: between two of the file's they lie on a line.
AuMatrix past_of(const End& start, const std::vector<std::string>& names, const TransitionEndOptions& options,
                 std::vector<std::string>& notes) {
  const double rows_per_frame = start.rate_hz.value_or(options.rate_hz) / options.rate_hz;
  const auto last = static_cast<double>(start.row);
  const Index rows = std::min<Index>(options.most_past_frames, static_cast<Index>(last / rows_per_frame + 1e-9) + 1);
  AuMatrix past(rows, static_cast<Index>(names.size()));
  for (Index row = 0; row < rows; ++row) {
    const double at = std::max(0.0, last - static_cast<double>(rows - 1 - row) * rows_per_frame);
    const auto before = static_cast<std::size_t>(at);
    const auto share = static_cast<float>(at - static_cast<double>(before));
    const std::size_t after = std::min(start.row, before + 1);
    std::vector<std::string>* const noted = row + 1 == rows ? &notes : nullptr;
    past.row(row) = row_of(start, before, names, noted);
    if (share > 0) past.row(row) += share * (row_of(start, after, names, nullptr) - past.row(row));
  }
  return past;
}

/// What the target's file moves and the start's has no column for.
void note_left_out(const End& end, const std::vector<std::string>& names, std::vector<std::string>& notes) {
  std::set<std::size_t> taken;
  for (const std::string& name : names) {
    for (const std::size_t column : columns_for(end.series->names, name)) taken.insert(column);
  }
  std::string left_out;
  for (std::size_t column = 0; column < end.series->names.size(); ++column) {
    if (!taken.contains(column) && end.series->intensities[end.row][column] > kLeastNoted)
      left_out += " " + end.series->names[column];
  }
  if (!left_out.empty()) notes.push_back(end.argument + " wants" + left_out + ", for which there is no column");
}

/// A target of which nothing is an AU of the start would be a face at rest.
void require_common(const End& end, const std::vector<std::string>& names, const std::string& start) {
  for (const std::string& name : names) {
    if (!columns_for(end.series->names, name).empty()) return;
  }
  throw UserError(end.argument, fmt::format("has none of the AUs of {}, such as {}", start, names.front()),
                  fmt::format("its columns are {} and so on; name them alike", end.series->names.front()));
}

}  // namespace

std::string file_of_end(const std::string& end) {
  for (const std::string& path : {end, end.substr(0, end.rfind(':'))})
    if (std::filesystem::is_regular_file(path)) return path;
  return {};
}

TransitionEnds transition_ends(const std::string& from, const std::string& to,
                               const std::vector<std::string>& default_names, const TransitionEndOptions& options) {
  const End start = end_of_argument(from, true, options.from_rate_hz), end = end_of_argument(to, false);
  TransitionEnds ends;
  for (const End* one : {&start, &end}) ends.notes.insert(ends.notes.end(), one->warnings.begin(), one->warnings.end());
  ends.names = start.series ? start.series->names : end.series ? end.series->names : default_names;
  if (end.series) {
    require_common(end, ends.names, from);
    note_left_out(end, ends.names, ends.notes);
  }
  if (!start.series && options.from_rate_hz) ends.notes.push_back(from + " is one pose: its rate means nothing");
  if (start.series) {
    ends.past = past_of(start, ends.names, options, ends.notes);
    if (!start.rate_hz && start.row > 0) {
      ends.notes.push_back(fmt::format("{} states no rate: {:g} Hz assumed, by which its velocity goes", start.argument,
                                       options.rate_hz));
    }
  } else {
    ends.past = expression_of(start, ends.names, ends.notes);
  }
  ends.target =
      (end.series ? row_of(end, end.row, ends.names, &ends.notes) : expression_of(end, ends.names, ends.notes))
          .transpose();
  return ends;
}

}  // namespace risorius
