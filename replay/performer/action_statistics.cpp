#include "replay/performer/action_statistics.h"

#include <algorithm>
#include <cmath>

#include "replay/takes/au_column.h"
#include "replay/takes/au_timeline.h"

namespace risorius {
namespace {

constexpr double kMinimumJerkWhole = 1.65;  // minimum jerk goes from 10 % to 90 % in 0.606 of its time

bool is_lid(const std::string& name) {
  const int number = parse_au_column(name).number;
  return number == 45 || number == 43;
}

std::vector<double> column_of(const PreparedSeries& series, std::size_t k) {
  std::vector<double> column;
  for (const auto& row : series.rows) column.push_back(row[k]);
  return column;
}

/// The resting level, found every half second and interpolated.
std::vector<double> resting_level(const std::vector<double>& x, double rate_hz, const ActionOptions& options) {
  const auto window = static_cast<std::ptrdiff_t>(options.rest_window_s * rate_hz);
  const auto stride = std::max<std::ptrdiff_t>(1, static_cast<std::ptrdiff_t>(rate_hz / 2));
  const auto count = static_cast<std::ptrdiff_t>(x.size());
  std::vector<double> knots;
  for (std::ptrdiff_t f = 0; f < count + stride; f += stride) {
    const auto from = std::clamp<std::ptrdiff_t>(f - window, 0, count - 1);
    const auto to = std::clamp<std::ptrdiff_t>(f + window, from + 1, count);
    knots.push_back(quantile_of({x.begin() + from, x.begin() + to}, options.rest_share));
  }
  std::vector<double> level(x.size());
  for (std::ptrdiff_t f = 0; f < count; ++f) {
    const auto knot = static_cast<std::size_t>(f / stride);
    const double u = static_cast<double>(f % stride) / static_cast<double>(stride);
    level[static_cast<std::size_t>(f)] = (1 - u) * knots[knot] + u * knots[std::min(knot + 1, knots.size() - 1)];
  }
  return level;
}

/// Fills in the times of an action between two frames (first above the low threshold, first below it again).
AuAction measure(const std::vector<double>& x, std::size_t from, std::size_t to, double rate_hz) {
  AuAction action;
  action.begin_s = static_cast<double>(from) / rate_hz;
  action.end_s = static_cast<double>(to) / rate_hz;
  std::size_t first_high = to, last_high = from;
  for (std::size_t f = from; f < to; ++f) {
    action.peak = std::max(action.peak, x[f]);
    const double before = x[f > 0 ? f - 1 : 0], after = x[std::min(f + 1, x.size() - 1)];
    action.peak_velocity = std::max(action.peak_velocity, std::abs(after - before) * rate_hz / 2);
  }
  for (std::size_t f = from; f < to; ++f) {
    if (x[f] < 0.9 * action.peak) continue;
    first_high = std::min(first_high, f);
    last_high = f;
  }
  const auto walk = [&](std::size_t start, int step) {
    std::size_t f = start, frames = 0;
    while (x[f] > 0.1 * action.peak && f > 0 && f + 1 < x.size()) {
      f = step < 0 ? f - 1 : f + 1;
      ++frames;
    }
    return kMinimumJerkWhole * static_cast<double>(frames) / rate_hz;
  };
  action.onset_s = walk(first_high, -1);
  action.offset_s = walk(last_high, 1);
  action.hold_s = static_cast<double>(last_high - first_high + 1) / rate_hz;
  return action;
}

}  // namespace

double quantile_of(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const double position = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const auto at = [&](std::size_t i) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i), values.end());
    return values[i];
  };
  const double low = at(below), high = at(std::min(below + 1, values.size() - 1));
  return low + (position - static_cast<double>(below)) * (high - low);
}

PreparedSeries prepare_series(const AuSeries& series, double rate_hz, const ActionOptions& options) {
  PreparedSeries prepared{.rate_hz = options.grid_hz};
  for (const std::string& name : series.names) {
    if (!is_lid(name)) prepared.names.push_back(name);
  }
  const AuTimeline timeline(series, rate_hz, prepared.names);
  const auto frames = static_cast<std::size_t>(timeline.seconds() * options.grid_hz) + 1;
  prepared.rows.assign(frames, std::vector<double>(prepared.names.size()));
  for (std::size_t f = 0; f < frames; ++f) timeline.at(static_cast<double>(f) / options.grid_hz, prepared.rows[f]);
  prepared.rest = prepared.rows;
  for (std::size_t k = 0; k < prepared.names.size(); ++k) {
    const std::vector<double> x = column_of(prepared, k);
    const std::vector<double> level = resting_level(x, options.grid_hz, options);
    for (std::size_t f = 0; f < frames; ++f) {
      const double smooth = (x[f > 0 ? f - 1 : 0] + x[f] + x[std::min(f + 1, frames - 1)]) / 3;
      prepared.rest[f][k] = level[f];
      prepared.rows[f][k] = std::max(0.0, smooth - level[f]);
    }
  }
  return prepared;
}

PreparedSeries part_of(const PreparedSeries& series, std::size_t first, std::size_t count) {
  const std::size_t last = std::min(series.rows.size(), first + count);
  const auto from = static_cast<std::ptrdiff_t>(std::min(first, last)), to = static_cast<std::ptrdiff_t>(last);
  return {series.names,
          series.rate_hz,
          {series.rows.begin() + from, series.rows.begin() + to},
          {series.rest.begin() + from, series.rest.begin() + to}};
}

std::vector<AuAction> find_actions(const PreparedSeries& series, const ActionOptions& options) {
  std::vector<AuAction> actions;
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    const std::vector<double> x = column_of(series, k);
    std::size_t f = 0;
    while (f < x.size() && x[f] >= options.low) ++f;  // an action that was going on before
    while (f < x.size()) {
      if (x[f] < options.low) {
        ++f;
        continue;
      }
      const std::size_t from = f;
      while (f < x.size() && x[f] >= options.low) ++f;
      if (f == x.size()) break;
      AuAction action = measure(x, from, f, series.rate_hz);
      action.au = k;
      if (action.peak >= options.high) actions.push_back(action);
    }
  }
  return actions;
}

ActionDistributions distributions_of(const std::vector<AuAction>& actions) {
  ActionDistributions out;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    out.peak_velocity.push_back(actions[i].peak_velocity);
    out.duration_s.push_back(actions[i].end_s - actions[i].begin_s);
    if (i > 0 && actions[i - 1].au == actions[i].au)
      out.rest_to_rest_s.push_back(actions[i].end_s - actions[i - 1].end_s);
  }
  return out;
}

void append(ActionDistributions& to, const ActionDistributions& more) {
  for (std::vector<double> ActionDistributions::*values :
       {&ActionDistributions::peak_velocity, &ActionDistributions::duration_s, &ActionDistributions::rest_to_rest_s})
    (to.*values).insert((to.*values).end(), (more.*values).begin(), (more.*values).end());
}

}  // namespace risorius
