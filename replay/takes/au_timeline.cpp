#include "replay/takes/au_timeline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Bridges what is not observed linearly, holds the ends; all 0 where nothing is observed.
void bridge(std::vector<double>& values) {
  std::ptrdiff_t last = -1;
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const auto value = values[static_cast<std::size_t>(i)];
    if (std::isnan(value)) continue;
    const double from = last < 0 ? value : values[static_cast<std::size_t>(last)];
    for (std::ptrdiff_t j = last + 1; j < i; ++j) {
      const double share = last < 0 ? 1 : static_cast<double>(j - last) / static_cast<double>(i - last);
      values[static_cast<std::size_t>(j)] = from + share * (value - from);
    }
    last = i;
  }
  const double end = last < 0 ? 0 : values[static_cast<std::size_t>(last)];
  for (std::ptrdiff_t j = last + 1; j < count; ++j) values[static_cast<std::size_t>(j)] = end;
}

/// The harmonic mean of the neighbouring steps, 0 at a turning point: the curve stays between its samples.
double slope_between(double before, double after) noexcept {
  return before * after <= 0 ? 0 : 2 * before * after / (before + after);
}

}  // namespace

AuTimeline::AuTimeline(const AuSeries& series, double rate_hz, const std::vector<std::string>& names)
    : width_(names.size()), rate_hz_(rate_hz) {
  if (series.frames.empty() || !(rate_hz > 0) || !std::isfinite(rate_hz))
    throw std::invalid_argument("AuTimeline: a series without frames, or a rate that is not above 0");
  const std::uint64_t first = series.frames.front(), length = series.frames.back() - first + 1;
  if (!std::is_sorted(series.frames.begin(), series.frames.end()) || length > 100'000'000)
    throw std::invalid_argument("AuTimeline: frame numbers do not grow, or reach too far");
  seconds_ = static_cast<double>(length - 1) / rate_hz;
  grid_.assign(length * width_, 0);
  slopes_.assign(length * width_, 0);
  std::vector<char> used(series.names.size(), 0);
  std::vector<double> curve(length);
  for (std::size_t k = 0; k < width_; ++k) {
    const std::vector<std::size_t> columns = columns_for(series.names, names[k]);
    if (columns.empty()) masked_.push_back(names[k]);
    for (const std::size_t column : columns) used[column] = 1;
    std::fill(curve.begin(), curve.end(), kNone);
    for (std::size_t f = 0; f < series.frames.size() && !columns.empty(); ++f) {
      double sum = 0;
      for (const std::size_t column : columns) sum += series.intensities[f][column];
      curve[series.frames[f] - first] = sum / static_cast<double>(columns.size());
    }
    bridge(curve);
    for (std::size_t f = 0; f < length; ++f) grid_[f * width_ + k] = curve[f];
    for (std::size_t f = 1; f + 1 < length; ++f)
      slopes_[f * width_ + k] = slope_between(curve[f] - curve[f - 1], curve[f + 1] - curve[f]);
  }
  for (std::size_t column = 0; column < used.size(); ++column) {
    if (used[column] == 0) unused_.push_back(series.names[column]);
  }
}

void AuTimeline::at(double time_s, std::span<double> values) const noexcept {
  const double last = seconds_ * rate_hz_;
  const double position = std::clamp(time_s * rate_hz_, 0.0, last);
  const auto from = static_cast<std::size_t>(position);
  const bool at_end = (from + 1) * width_ >= grid_.size();
  const double u = at_end ? 0 : position - static_cast<double>(from);
  const std::size_t a = from * width_, b = at_end ? a : a + width_;
  // Hermite's cubic on [0, 1].
  const double u2 = u * u, u3 = u2 * u;
  const double ha = 2 * u3 - 3 * u2 + 1, hb = 1 - ha, da = u3 - 2 * u2 + u, db = u3 - u2;
  for (std::size_t k = 0; k < values.size() && k < width_; ++k)
    values[k] = ha * grid_[a + k] + hb * grid_[b + k] + da * slopes_[a + k] + db * slopes_[b + k];
}

}  // namespace risorius
