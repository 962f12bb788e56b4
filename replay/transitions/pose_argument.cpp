#include "replay/transitions/pose_argument.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>

#include "capture/errors.h"
#include "replay/performer/expression_vector.h"
#include "replay/takes/arkit_aus.h"
#include "replay/takes/au_csv.h"
#include "replay/takes/live_link_csv.h"

namespace risorius {
namespace {

using Eigen::Index;

/// One end: a series up to or from a frame, or an expression.
struct End {
  std::string argument;
  std::optional<AuSeries> series;
  std::size_t row = 0;  ///< of the series
};

AuSeries load_series(const std::string& path) {
  if (!is_live_link_csv(path)) return load_au_csv(path);
  return aus_of_shapes(load_live_link_csv(path).shapes, shipped_arkit_table(), JawColumns::kWhole, true);
}

/// A series is a file that is there; "FILE:FRAME" one of its frames.
End end_of_argument(const std::string& argument, bool is_start) {
  End end{argument, std::nullopt, 0};
  if (std::filesystem::is_regular_file(argument)) {
    end.series = load_series(argument);
    end.row = is_start ? end.series->frames.size() - 1 : 0;
    return end;
  }
  const std::size_t colon = argument.rfind(':');
  const std::string path = argument.substr(0, colon);
  if (colon == std::string::npos || !std::filesystem::is_regular_file(path)) {
    if (path.ends_with(".csv"))
      throw UserError(path, "is no file", "give an AU series, or an expression: " + expression_names());
    return end;
  }
  end.series = load_series(path);
  const std::string_view digits = std::string_view(argument).substr(colon + 1);
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
  std::string lacking, unobserved;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::vector<std::size_t> columns = columns_for(end.series->names, names[k]);
    double sum = 0;
    for (const std::size_t column : columns) sum += end.series->intensities[row][column];
    if (columns.empty()) {
      lacking += " " + names[k];
    } else if (std::isnan(sum)) {
      unobserved += " " + names[k];
    } else {
      values[static_cast<Index>(k)] =
          static_cast<float>(std::clamp(sum / static_cast<double>(columns.size()), 0.0, 1.2));
    }
  }
  if (notes != nullptr && !lacking.empty()) notes->push_back(end.argument + " has no" + lacking + ": taken as 0");
  if (notes != nullptr && !unobserved.empty())
    notes->push_back(end.argument + " does not observe" + unobserved + " there: taken as 0");
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

}  // namespace

TransitionEnds transition_ends(const std::string& from, const std::string& to,
                               const std::vector<std::string>& default_names, Index most_past_frames) {
  const End start = end_of_argument(from, true), end = end_of_argument(to, false);
  TransitionEnds ends;
  ends.names = start.series ? start.series->names : end.series ? end.series->names : default_names;
  const auto aus = static_cast<Index>(ends.names.size());
  if (start.series) {
    const Index rows = std::min<Index>(most_past_frames, static_cast<Index>(start.row) + 1);
    ends.past.resize(rows, aus);
    for (Index row = 0; row < rows; ++row) {
      const bool is_last = row + 1 == rows;
      ends.past.row(row) = row_of(start, start.row - static_cast<std::size_t>(rows - 1 - row), ends.names,
                                  is_last ? &ends.notes : nullptr);
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
