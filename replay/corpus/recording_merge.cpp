#include "replay/corpus/recording_merge.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <stdexcept>

namespace risorius {
namespace {

/// Where among `known` the `count` neighbours begin that lie closest around `frame`; the earlier ones of equals.
std::size_t first_of_nearest(const std::vector<std::uint64_t>& known, std::uint64_t frame, std::size_t count) {
  const auto after = static_cast<std::size_t>(std::lower_bound(known.begin(), known.end(), frame) - known.begin());
  const auto distance = [&](std::size_t i) { return known[i] < frame ? frame - known[i] : known[i] - frame; };
  const auto reach = [&](std::size_t first) { return std::max(distance(first), distance(first + count - 1)); };
  std::size_t best = after > count ? after - count : 0;
  for (std::size_t first = best; first <= after && first + count <= known.size(); ++first) {
    if (reach(first) < reach(best)) best = first;
  }
  return best;
}

/// Equation (5.2): the polynomial through (frames[i], values[i]) at `frame`.
double lagrange(std::span<const std::uint64_t> frames, const std::vector<const std::vector<double>*>& rows,
                std::size_t column, std::uint64_t frame) {
  double sum = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    double weight = 1;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (k == i) continue;
      weight *= (static_cast<double>(frame) - static_cast<double>(frames[k])) /
                (static_cast<double>(frames[i]) - static_cast<double>(frames[k]));
    }
    sum += weight * (*rows[i])[column];
  }
  return sum;
}

}  // namespace

MergedSeries merge_recordings(std::span<const AuSeries> recordings, MergeDegree degree) {
  if (recordings.empty()) throw std::invalid_argument("merge_recordings: no recording");
  MergedSeries merged;
  merged.series.names = recordings.front().names;
  std::map<std::uint64_t, const std::vector<double>*> rows;
  for (const AuSeries& recording : recordings) {
    if (recording.names != merged.series.names)
      throw std::invalid_argument("merge_recordings: the recordings have different AUs");
    for (std::size_t f = 0; f < recording.frames.size(); ++f) {
      if (!rows.emplace(recording.frames[f], &recording.intensities[f]).second) ++merged.duplicates;
    }
  }
  const std::size_t points = static_cast<std::size_t>(degree) + 1;
  if (rows.size() < points)
    throw std::invalid_argument(fmt::format("merge_recordings: {} frames, the degree needs {}", rows.size(), points));
  std::vector<std::uint64_t> known;
  for (const auto& [frame, row] : rows) known.push_back(frame);
  if (known.back() - known.front() > 100'000'000)
    throw std::invalid_argument("merge_recordings: the frame numbers reach too far");
  std::uint64_t gap = 0;
  for (std::uint64_t frame = known.front(); frame <= known.back(); ++frame) {
    merged.series.frames.push_back(frame);
    if (const auto row = rows.find(frame); row != rows.end()) {
      merged.series.intensities.push_back(*row->second);
      gap = 0;
      continue;
    }
    merged.missing.push_back(frame);
    merged.longest_gap = std::max(merged.longest_gap, ++gap);
    const std::size_t first = first_of_nearest(known, frame, points);
    std::vector<const std::vector<double>*> nearest;
    for (std::size_t i = 0; i < points; ++i) nearest.push_back(rows[known[first + i]]);
    auto& values = merged.series.intensities.emplace_back(merged.series.names.size());
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = lagrange({known.data() + first, points}, nearest, k, frame);
  }
  return merged;
}

}  // namespace risorius
