#include "replay/performer/dynamics_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "replay/performer/au_wander.h"
#include "replay/performer/performer_script.h"
#include "replay/takes/au_column.h"

namespace risorius {
namespace {

constexpr std::size_t kLeastActions = 30;
constexpr double kLeastProbability = 0.15, kLeastRatio = 0.1;  // co-activations below are noise
constexpr double kActing = 0.3;                                // an action strong enough to bring others along
constexpr double kStep = 0.6;                                  // of a correction, per round
constexpr double kWidest = 1.1;                                // log-normal spread of holds: 90 % within a factor of 6
constexpr double kWidestRest = 0.9;                            // of rests within a run
constexpr double kHighest = 1.15;

double median_of(const std::vector<double>& values) { return quantile_of(values, 0.5); }

/// Median and spread by quantiles, which a few odd actions do not bend.
LogNormal log_normal_of(const std::vector<double>& values) {
  const double median = std::max(median_of(values), 0.03);
  return {median, std::clamp(std::log(std::max(quantile_of(values, 0.9), median) / median) / 1.2816, 0.05, 1.5)};
}

/// An AU without its side.
std::string base_of(const std::string& name) {
  const AuColumn column = parse_au_column(name);
  return column.number != 0 && column.number != 30 ? "AU" + std::to_string(column.number) : name;
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
    if (!name.ends_with('L') || base_of(name) == name || action.peak < kActing) continue;
    const auto found = std::find(series.names.begin(), series.names.end(), base_of(name) + "R");
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

void fit_co_actions(const PreparedSeries& series, const std::vector<AuAction>& actions, Dynamics& dynamics) {
  std::map<std::string, std::vector<std::size_t>> columns;
  for (std::size_t k = 0; k < series.names.size(); ++k) columns[base_of(series.names[k])].push_back(k);
  struct Seen {
    double together = 0;
    std::vector<double> ratios;
  };
  std::map<std::string, double> times;
  std::map<std::string, std::map<std::string, Seen>> seen;
  for (const AuAction& action : actions) {
    const std::string& name = series.names[action.au];
    const std::string base = base_of(name);
    if (action.peak < kActing || (base != name && name.ends_with('R'))) continue;
    times[base] += 1;
    const auto from = static_cast<std::size_t>(action.begin_s * series.rate_hz);
    const auto to = static_cast<std::size_t>(action.end_s * series.rate_hz);
    for (const auto& [other, others] : columns) {
      if (other == base) continue;
      double peak = 0;
      for (std::size_t f = from; f < to; ++f) {
        for (const std::size_t k : others) peak = std::max(peak, series.rows[f][k]);
      }
      // Of two that act together the stronger one leads.
      if (peak < ActionOptions{}.high || peak > action.peak) continue;
      seen[base][other].together += 1;
      seen[base][other].ratios.push_back(peak / action.peak);
    }
  }
  for (const auto& [base, others] : seen) {
    for (const auto& [other, what] : others) {
      const double probability = what.together / times[base], ratio = median_of(what.ratios);
      if (times[base] < 3 || probability < kLeastProbability || ratio < kLeastRatio) continue;
      dynamics.co_actions[base].push_back({other, std::min(probability, 0.97), ratio});
    }
  }
}

/// Variance and memory of wandering from differences over two lags: D(t) = 2 s^2 (1 - r(t)), where r of two low-passes
/// in a row is (1 + t / T) exp(-t / T).
Wander wander_of(double near_difference, double near_s, double far_difference, double far_s) {
  const double deviation = std::sqrt(std::max(far_difference, 1e-12) / 2);
  const double wanted = std::clamp(near_difference / std::max(far_difference, 1e-12), 1e-3, 0.98);
  double low = 1e-3, high = far_s;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), u = near_s / middle, v = far_s / middle;
    const double ratio = (1 - (1 + u) * std::exp(-u)) / (1 - (1 + v) * std::exp(-v));
    (ratio > wanted ? low : high) = middle;
  }
  return {deviation, low};
}

/// Micro-motion from stretches in which an AU rests; drift from how its resting level wanders.
void fit_wandering(const PreparedSeries& series, Dynamics& dynamics) {
  std::vector<double> near, far, drift_near, drift_far;
  const auto far_lag = static_cast<std::size_t>(0.5 * series.rate_hz);
  const auto drift_lag = static_cast<std::size_t>(5 * series.rate_hz), longest = 4 * drift_lag;
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    for (std::size_t f = 0; f + far_lag < series.rows.size(); ++f) {
      bool rests = true;
      for (std::size_t g = f; g <= f + far_lag && rests; ++g) rests = series.rows[g][k] < ActionOptions{}.low;
      if (!rests) continue;
      near.push_back(std::abs(series.rows[f + 1][k] - series.rows[f][k]));
      far.push_back(std::abs(series.rows[f + far_lag][k] - series.rows[f][k]));
    }
    for (std::size_t f = 0; f + longest < series.rows.size(); f += drift_lag) {
      drift_near.push_back(std::abs(series.rest[f + drift_lag][k] - series.rest[f][k]));
      drift_far.push_back(std::abs(series.rest[f + longest][k] - series.rest[f][k]));
    }
  }
  // Squares from quantiles: the tails of resting are actions below the threshold.
  const auto square = [](std::vector<double> values) {
    const double one = quantile_of(std::move(values), 0.683);
    return one * one;
  };
  const auto lag_s = [&](std::size_t frames) { return static_cast<double>(frames) / series.rate_hz; };
  dynamics.micro_motion = wander_of(square(near), lag_s(1), square(far), lag_s(far_lag));
  dynamics.rest_drift = wander_of(square(drift_near), lag_s(drift_lag), square(drift_far), lag_s(longest));
}

/// What simulated moments compare.
struct Moments {
  double velocity_50, velocity_90, duration_50, duration_90, interval_50, interval_90;
};

Moments moments_of(const ActionDistributions& d) {
  const auto q = [](const std::vector<double>& v, double share) { return std::max(quantile_of(v, share), 1e-3); };
  return {q(d.peak_velocity, 0.5), q(d.peak_velocity, 0.9),  q(d.duration_s, 0.5),
          q(d.duration_s, 0.9),    q(d.rest_to_rest_s, 0.5), q(d.rest_to_rest_s, 0.9)};
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

/// Moves a distribution so that what it makes comes nearer to what was recorded.
void correct(LogNormal& d, double real_50, double real_90, double made_50, double made_90, double least, double most) {
  const double at_50 = std::clamp(std::log(real_50 / made_50), -0.7, 0.7);
  const double at_90 = std::clamp(std::log(real_90 / made_90), -0.7, 0.7);
  d.median = std::clamp(d.median * std::exp(kStep * at_50), least, most);
  d.sigma = std::clamp(d.sigma + kStep * 0.5 * (at_90 - at_50), 0.05, kWidest);
}

/// The median follows the rest within runs of repetitions and how long the runs are; the 90th percentile how often an
/// AU is brought along by others.
void correct_rests(Dynamics& dynamics, const Moments& real, const Moments& made) {
  const double at_50 = std::clamp(std::log(real.interval_50 / made.interval_50), -0.7, 0.7);
  const double at_90 = std::clamp(std::log(real.interval_90 / made.interval_90), -0.7, 0.7);
  dynamics.rest_s.median = std::clamp(dynamics.rest_s.median * std::exp(kStep * at_50), 0.05, 20.0);
  const double p = dynamics.repeat_probability;
  const double odds = p / (1 - p) * std::exp(-0.5 * kStep * at_50);
  dynamics.repeat_probability = std::clamp(odds / (1 + odds), 0.02, 0.9);
  // What was counted as together had to pass thresholds, and what is performed has to pass them again.
  for (auto& [au, list] : dynamics.co_actions) {
    for (CoAction& other : list) {
      const double other_odds = other.probability / (1 - other.probability) * std::exp(-0.5 * kStep * at_90);
      other.probability = std::clamp(other_odds / (1 + other_odds), 0.02, 0.97);
    }
  }
}

double distance_of(const Moments& real, const Moments& made) {
  double worst = 0;
  for (const auto& [r, m] : {std::pair{real.velocity_50, made.velocity_50},
                             {real.velocity_90, made.velocity_90},
                             {real.duration_50, made.duration_50},
                             {real.duration_90, made.duration_90},
                             {real.interval_50, made.interval_50},
                             {real.interval_90, made.interval_90}})
    worst = std::max(worst, std::abs(m / r - 1));
  return worst;
}

}  // namespace

AuSeries perform_range_of_motion(const std::vector<std::string>& names, const Dynamics& dynamics, double seconds,
                                 std::uint64_t seed) {
  constexpr double kRateHz = 30;
  PerformerScript script(names, {ScriptKind::kRom, seconds, seed, true, false}, dynamics);
  AuWander wander(names.size(), dynamics.micro_motion, dynamics.rest_drift, 1, kRateHz, seed);
  const std::vector<double> upper(names.size(), kHighest);
  AuSeries series{.names = names};
  const auto frames = static_cast<std::uint64_t>(seconds * kRateHz);
  for (std::uint64_t f = 0; f < frames; ++f) {
    std::vector<double>& row = series.intensities.emplace_back(names.size());
    script.intensities_at(static_cast<double>(f) / kRateHz, row);
    wander.add_to(row, upper);
    series.frames.push_back(f);
  }
  return series;
}

Dynamics fit_dynamics(const PreparedSeries& recorded, const DynamicsFitOptions& options,
                      const std::function<void(int, int)>& progress) {
  const std::vector<AuAction> actions = find_actions(recorded);
  if (actions.size() < kLeastActions)
    throw std::invalid_argument("fit_dynamics: " + std::to_string(actions.size()) +
                                " actions are too few; 30 are needed");
  Dynamics dynamics;
  // A way's duration from its fastest moment (minimum jerk: 1.875 peak / duration): slow tails are not the movement.
  std::vector<double> onset, offset, hold;
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
  std::vector<double> rests;
  for (std::size_t i = 1; i < actions.size(); ++i) {
    if (actions[i].au == actions[i - 1].au) rests.push_back(actions[i].begin_s - actions[i - 1].end_s);
  }
  dynamics.rest_s = {
      std::max(0.1, median_of(rests)),
      std::clamp(std::log(median_of(rests) / std::max(0.03, quantile_of(rests, 0.1))) / 1.2816, 0.05, kWidestRest)};
  dynamics.repeat_probability = 0.5;
  const double offset_per_onset = std::clamp(median_of(offset), 0.5, 2.0);
  dynamics.offset_s = {dynamics.onset_s.median * offset_per_onset, dynamics.onset_s.sigma};
  fit_sides(recorded, actions, dynamics);
  fit_skews(recorded, actions, dynamics);
  fit_co_actions(recorded, actions, dynamics);
  fit_wandering(recorded, dynamics);

  const Moments real = moments_of(distributions_of(actions));
  const double seconds = static_cast<double>(recorded.rows.size()) / recorded.rate_hz;
  Dynamics best = dynamics;
  double nearest = 1e9;
  for (int round = 0; round < options.rounds; ++round) {
    if (progress) progress(round, options.rounds);
    const Moments made =
        moments_of(performed_distributions(recorded.names, dynamics, seconds, options.takes, options.seed));
    const double distance = distance_of(real, made);
    if (distance < nearest) {
      nearest = distance;
      best = dynamics;
    }
    correct(dynamics.peak, real.velocity_50, real.velocity_90, made.velocity_50, made.velocity_90, 0.1, 0.95);
    correct(dynamics.hold_s, real.duration_50, real.duration_90, made.duration_50, made.duration_90, 0.03, 20);
    correct_rests(dynamics, real, made);
  }
  return best;
}

ActionDistributions performed_distributions(const std::vector<std::string>& names, const Dynamics& dynamics,
                                            double seconds, int takes, std::uint64_t seed) {
  ActionDistributions all;
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (int take = 0; take < takes; ++take) {
    const AuSeries series =
        perform_range_of_motion(names, dynamics, seconds, 1000 * seed + static_cast<std::uint64_t>(take));
    const ActionDistributions one = distributions_of(find_actions(prepare_series(series, 30)));
    append(all.peak_velocity, one.peak_velocity);
    append(all.duration_s, one.duration_s);
    append(all.rest_to_rest_s, one.rest_to_rest_s);
  }
  return all;
}

}  // namespace risorius
