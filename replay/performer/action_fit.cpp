#include "replay/performer/action_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "replay/performer/posture_fit.h"

namespace risorius {
namespace {

constexpr double kActing = 0.3;      // an action strong enough for its ways to be seen
constexpr double kWidestRest = 0.9;  // log-normal spread of rests within a run

double median_of(const std::vector<double>& values) { return quantile_of(values, 0.5); }

/// Median and spread by quantiles, which a few odd actions do not bend.
LogNormal log_normal_of(const std::vector<double>& values) {
  const double median = std::max(median_of(values), 0.03);
  return {median, std::clamp(std::log(std::max(quantile_of(values, 0.9), median) / median) / 1.2816, 0.05, 1.5)};
}

/// Lag (s) at which the right side follows the left best, within 0.1 s, to a tenth of a frame by a parabola.
std::optional<double> lag_between(const PreparedSeries& series, std::size_t left, std::size_t right,
                                  const AuAction& action) {
  const auto from = static_cast<std::ptrdiff_t>(action.begin_s * series.rate_hz) - 6;
  const auto to = static_cast<std::ptrdiff_t>(action.end_s * series.rate_hz) + 6;
  const auto count = static_cast<std::ptrdiff_t>(series.rows.size());
  constexpr std::ptrdiff_t kReach = 3;
  if (from < kReach || to + kReach >= count) return std::nullopt;
  std::vector<double> product;
  for (std::ptrdiff_t lag = -kReach; lag <= kReach; ++lag) {
    double sum = 0;
    for (std::ptrdiff_t f = from; f < to; ++f) {
      const auto l = static_cast<std::size_t>(f), r = static_cast<std::size_t>(f + lag);
      const double dl = series.rows[l + 1][left] - series.rows[l][left];
      sum += dl * (series.rows[r + 1][right] - series.rows[r][right]);
    }
    product.push_back(sum);
  }
  const auto best = std::max_element(product.begin(), product.end()) - product.begin();
  if (best == 0 || best + 1 == static_cast<std::ptrdiff_t>(product.size())) return std::nullopt;
  const auto at = [&](std::ptrdiff_t i) { return product[static_cast<std::size_t>(i)]; };
  const double curve = at(best - 1) - 2 * at(best) + at(best + 1);
  const double shift = curve < 0 ? 0.5 * (at(best - 1) - at(best + 1)) / curve : 0;
  return (static_cast<double>(best - kReach) + shift) / series.rate_hz;
}

void fit_sides(const PreparedSeries& series, const std::vector<AuAction>& actions, Dynamics& dynamics) {
  std::vector<double> lags, gains;
  for (const AuAction& action : actions) {
    const std::string& name = series.names[action.au];
    if (!name.ends_with('L') || base_of_column(name) == name || action.peak < kActing) continue;
    const auto found = std::find(series.names.begin(), series.names.end(), base_of_column(name) + "R");
    if (found == series.names.end()) continue;
    const auto right = static_cast<std::size_t>(found - series.names.begin());
    double peak = 0;
    for (auto f = static_cast<std::size_t>(action.begin_s * series.rate_hz);
         static_cast<double>(f) < action.end_s * series.rate_hz; ++f)
      peak = std::max(peak, series.rows[f][right]);
    if (peak < 0.5 * action.peak) continue;  // one side was meant
    gains.push_back(std::log(action.peak / peak));
    if (const auto lag = lag_between(series, action.au, right, action)) lags.push_back(*lag);
  }
  // From quantiles: 68 % of a normal distribution lie within one deviation.
  const auto deviation = [](std::vector<double> values) {
    for (double& value : values) value = std::abs(value);
    return quantile_of(values, 0.683);
  };
  dynamics.side_lag_s = std::min(0.1, deviation(lags));
  dynamics.side_gain = std::min(0.5, deviation(gains));
}

/// Time to the middle of a rise, as share of the rise, tells the skew: k / (1 + k).
void fit_skews(const PreparedSeries& series, const std::vector<AuAction>& actions, Dynamics& dynamics) {
  std::vector<double> onset, offset;
  for (const AuAction& action : actions) {
    if (action.peak < kActing) continue;
    const auto from = static_cast<std::size_t>(action.begin_s * series.rate_hz);
    const auto to = static_cast<std::size_t>(action.end_s * series.rate_hz);
    std::size_t top = from;
    while (top < to && series.rows[top][action.au] < 0.9 * action.peak) ++top;
    std::size_t leave = to;
    while (leave > top && series.rows[leave - 1][action.au] < 0.9 * action.peak) --leave;
    const auto share_of_way = [&](std::size_t low, std::size_t high, bool rising) {
      if (high < low + 4) return;  // too short to tell at this rate
      std::size_t middle = low;
      while (middle < high && (series.rows[middle][action.au] < 0.5 * action.peak) == rising) ++middle;
      const double share = static_cast<double>(middle - low) / static_cast<double>(high - low);
      if (share > 0.1 && share < 0.9) (rising ? onset : offset).push_back(share / (1 - share));
    };
    share_of_way(from, top, true);
    share_of_way(leave, to, false);
  }
  dynamics.onset_skew = onset.empty() ? 1 : std::clamp(median_of(onset), 0.4, 2.5);
  dynamics.offset_skew = offset.empty() ? 1 : std::clamp(median_of(offset), 0.4, 2.5);
}

/// Peaks of the actions that lead: no other that is going on at their middle is stronger. What comes along with them is
/// left to the co-activations.
std::vector<double> leading_peaks(const std::vector<AuAction>& actions) {
  std::vector<double> peaks;
  for (const AuAction& action : actions) {
    const double middle_s = 0.5 * (action.begin_s + action.end_s);
    const bool leads = std::none_of(actions.begin(), actions.end(), [&](const AuAction& other) {
      return other.begin_s < middle_s && other.end_s > middle_s && other.peak > action.peak;
    });
    if (leads) peaks.push_back(action.peak);
  }
  return peaks;
}

}  // namespace

void fit_single_actions(const PreparedSeries& series, const std::vector<AuAction>& actions, Dynamics& dynamics) {
  // A way's duration from its fastest moment (minimum jerk: 1.875 peak / duration): slow tails are not the movement.
  std::vector<double> onset, offset, hold, rests;
  for (const AuAction& action : actions) {
    if (action.peak < kActing) continue;
    const double way_s = 1.875 * action.peak / action.peak_velocity;
    onset.push_back(way_s);
    hold.push_back(std::max(0.03, action.end_s - action.begin_s - way_s));
  }
  for (const AuAction& action : actions) offset.push_back(action.offset_s / std::max(action.onset_s, 1.0 / 30));
  dynamics.onset_s = log_normal_of(onset);
  dynamics.hold_s = log_normal_of(hold);
  dynamics.peak = log_normal_of(leading_peaks(actions));
  // Short rests lie within a run of repetitions, long ones between runs: the lower half tells the spread.
  for (std::size_t i = 1; i < actions.size(); ++i) {
    if (actions[i].au == actions[i - 1].au) rests.push_back(actions[i].begin_s - actions[i - 1].end_s);
  }
  dynamics.rest_s = {
      std::max(0.1, median_of(rests)),
      std::clamp(std::log(median_of(rests) / std::max(0.03, quantile_of(rests, 0.1))) / 1.2816, 0.05, kWidestRest)};
  dynamics.repeat_probability = 0.5;
  const double offset_per_onset = std::clamp(median_of(offset), 0.5, 2.0);
  dynamics.offset_s = {dynamics.onset_s.median * offset_per_onset, dynamics.onset_s.sigma};
  fit_sides(series, actions, dynamics);
  fit_skews(series, actions, dynamics);
}

}  // namespace risorius
