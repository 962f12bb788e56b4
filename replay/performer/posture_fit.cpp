#include "replay/performer/posture_fit.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "replay/takes/au_column.h"

namespace risorius {
namespace {

constexpr double kShrink = 0.1;
constexpr double kActing = 0.3;      // an action strong enough for its timing to be seen
constexpr double kMoving = 0.15;     // a change of another AU that can be timed
constexpr double kAroundS = 0.3;     // before and after a way
constexpr double kJerkPeak = 1.875;  // peak velocity of minimum jerk, times duration, per change

/// Series by AU without sides, frames x AUs by column.
struct Bases {
  std::vector<std::string> aus;
  std::vector<std::vector<double>> values;  ///< one per AU, over the frames
};

Bases bases_of(const PreparedSeries& series) {
  std::map<std::string, std::vector<std::size_t>> columns;
  Bases bases;
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    const std::string base = base_of_column(series.names[k]);
    if (columns[base].empty()) bases.aus.push_back(base);
    columns[base].push_back(k);
  }
  for (const std::string& au : bases.aus) {
    std::vector<double>& values = bases.values.emplace_back();
    for (const auto& row : series.rows) {
      double sum = 0;
      for (const std::size_t k : columns[au]) sum += row[k];
      values.push_back(sum / static_cast<double>(columns[au].size()));
    }
  }
  return bases;
}

/// 68 % of a normal distribution lie within one deviation: odd values do not bend it.
double deviation_of(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return quantile_of(std::move(values), 0.683);
}

/// How an AU gets from one frame to another.
struct Way {
  double half_s = 0;      ///< when half of it is done
  double duration_s = 0;  ///< by its fastest moment
  bool splits = false;
  double split_share = 0, split_gap_s = 0;
};

Way way_of(const std::vector<double>& x, std::size_t from, std::size_t to, double rate_hz) {
  const double change = x[to] - x[from], sign = change > 0 ? 1 : -1;
  Way way;
  std::size_t middle = from;
  while (middle < to && (x[middle] - x[from]) / change < 0.5) ++middle;
  const double over = middle > from ? (x[middle] - x[from] - 0.5 * change) / (x[middle] - x[middle - 1]) : 0;
  way.half_s = (static_cast<double>(middle) - over) / rate_hz;
  std::vector<double> velocity;
  for (std::size_t f = from + 1; f < to; ++f) velocity.push_back(sign * (x[f + 1] - x[f - 1]) * rate_hz / 2);
  const double fastest = *std::max_element(velocity.begin(), velocity.end());
  way.duration_s = kJerkPeak * std::abs(change) / std::max(fastest, 1e-9);
  // Two fast moments with a slow one between: a second step.
  std::size_t peak = 0, valley = 0;
  bool has_peak = false, has_valley = false;
  for (std::size_t i = 1; i + 1 < velocity.size() && !way.splits; ++i) {
    const bool is_peak = velocity[i] > 0.2 * fastest && velocity[i] >= velocity[i - 1] && velocity[i] > velocity[i + 1];
    if (has_peak && (!has_valley || velocity[i] < velocity[valley])) {
      valley = i;
      has_valley = true;
    }
    if (!is_peak) continue;
    if (has_peak && has_valley && velocity[valley] < 0.6 * std::min(velocity[peak], velocity[i])) {
      way.splits = true;
      way.split_share = std::clamp((x[from + 1 + valley] - x[from]) / change, 0.1, 0.9);
      way.split_gap_s = static_cast<double>(i - peak) / rate_hz;
    } else if (!has_peak || velocity[i] > velocity[peak]) {
      peak = i;
      has_peak = true;
      has_valley = false;
    }
  }
  return way;
}

/// Collects ways of AUs that change together.
struct WaySamples {
  std::vector<double> lag_s, pace, split_share, split_gap;
  double ways = 0, splits = 0;

  void add(const Bases& bases, std::size_t leader, std::size_t from, std::size_t to, double rate_hz) {
    const Way leading = way_of(bases.values[leader], from, to, rate_hz);
    for (std::size_t k = 0; k < bases.aus.size(); ++k) {
      const double change = bases.values[k][to] - bases.values[k][from];
      if (std::abs(change) < kMoving) continue;
      const Way way = k == leader ? leading : way_of(bases.values[k], from, to, rate_hz);
      ways += 1;
      if (way.splits) {
        splits += 1;
        split_share.push_back(way.split_share);
        split_gap.push_back(way.split_gap_s / way.duration_s);
      }
      if (k == leader) continue;
      lag_s.push_back(way.half_s - leading.half_s);
      pace.push_back(std::log(way.duration_s / leading.duration_s));
    }
  }
};

/// What happens on top of held actions.
struct HoldSamples {
  std::vector<double> half_second_change;  ///< of the logarithm
  double seconds = 0, shifts = 0;

  void add(const std::vector<double>& x, std::size_t from, std::size_t to, double peak, double rate_hz) {
    const auto half = static_cast<std::size_t>(0.5 * rate_hz);
    for (std::size_t f = from; f + half < to; ++f) half_second_change.push_back(std::log(x[f + half] / x[f]));
    const auto speed = [&](std::size_t f) { return std::abs(x[f + 1] - x[f - 1]) * rate_hz / 2; };
    for (std::size_t f = from + 1; f + 2 < to; ++f)
      shifts += speed(f) > 0.2 * peak && speed(f) >= speed(f - 1) && speed(f) > speed(f + 1);
    seconds += static_cast<double>(to - from) / rate_hz;
  }
};

}  // namespace

std::string base_of_column(const std::string& name) {
  const AuColumn column = parse_au_column(name);
  return column.number != 0 && column.number != 30 ? "AU" + std::to_string(column.number) : name;
}

PostureTable fit_postures(const PreparedSeries& series) {
  const Bases bases = bases_of(series);
  const auto count = static_cast<Eigen::Index>(bases.aus.size()),
             frames = static_cast<Eigen::Index>(series.rows.size());
  PostureTable table{bases.aus, {}, Eigen::MatrixXd::Identity(count, count)};
  Eigen::MatrixXd scores(frames, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::vector<double>& values = bases.values[static_cast<std::size_t>(k)];
    PostureTable::Levels& levels = table.levels.emplace_back();
    for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = quantile_of(values, PostureTable::kShares[i]);
    const std::vector<double> of_au = normal_scores(values);
    scores.col(k) = Eigen::Map<const Eigen::VectorXd>(of_au.data(), frames);
    scores.col(k).array() -= scores.col(k).mean();
    scores.col(k) /= std::max(scores.col(k).norm(), 1e-9);
  }
  const Eigen::MatrixXd correlation = (1 - kShrink) * scores.transpose() * scores;
  table.correlation = correlation;
  table.correlation.diagonal().setOnes();
  return table;
}

Timing fit_timing(const PreparedSeries& series, const std::vector<AuAction>& actions) {
  const Bases bases = bases_of(series);
  WaySamples ways;
  HoldSamples holds;
  const auto around = static_cast<std::size_t>(kAroundS * series.rate_hz);
  const auto trim = static_cast<std::size_t>(0.15 * series.rate_hz);
  for (const AuAction& action : actions) {
    const std::string& name = series.names[action.au];
    const std::string base = base_of_column(name);
    if (action.peak < kActing || (base != name && name.ends_with('R'))) continue;
    const auto leader =
        static_cast<std::size_t>(std::find(bases.aus.begin(), bases.aus.end(), base) - bases.aus.begin());
    const std::vector<double>& x = bases.values[leader];
    const auto begin = static_cast<std::size_t>(action.begin_s * series.rate_hz);
    const auto end = static_cast<std::size_t>(action.end_s * series.rate_hz);
    std::size_t first = begin, last = end - 1;
    while (first < last && x[first] < 0.7 * action.peak) ++first;
    while (last > first && x[last] < 0.7 * action.peak) --last;
    if (begin >= around + 1 && first + around + 1 < x.size() && x[first + around] - x[begin - around] > kMoving)
      ways.add(bases, leader, begin - around, first + around, series.rate_hz);
    if (last >= around + 1 && end + around + 1 < x.size() && x[last - around] - x[end + around] > kMoving)
      ways.add(bases, leader, last - around, end + around, series.rate_hz);
    if (last > first + 2 * trim + 2) holds.add(x, first + trim, last - trim, action.peak, series.rate_hz);
  }
  Timing timing;
  // A lag is the difference of two AUs' settings-out, a pace the ratio of two ways.
  timing.lag_s = std::min(0.5, deviation_of(ways.lag_s) / std::sqrt(2));
  timing.pace = std::min(1.5, deviation_of(ways.pace) / std::sqrt(2));
  timing.split_probability = ways.ways > 0 ? ways.splits / ways.ways : 0;
  timing.split_share = ways.split_share.empty() ? 0.5 : quantile_of(ways.split_share, 0.5);
  timing.split_gap = ways.split_gap.empty() ? 0.5 : std::min(3.0, quantile_of(ways.split_gap, 0.5));
  timing.shifts_per_second = holds.seconds > 0 ? std::min(20.0, holds.shifts / holds.seconds) : 0;
  // Levels before and after at least one shift are independent: E(d^2) = 2 s^2 (1 - exp(-0.5 s * rate)).
  const double renewed = 1 - std::exp(-0.5 * timing.shifts_per_second);
  timing.apex_shift =
      renewed > 0.01 ? std::min(1.0, deviation_of(holds.half_second_change) / std::sqrt(2 * renewed)) : 0;
  return timing;
}

double posture_memory(const PreparedSeries& series, double lag_s) {
  const Bases bases = bases_of(series);
  const auto lag = static_cast<std::size_t>(lag_s * series.rate_hz);
  double sum = 0, squares = 0;
  for (const std::vector<double>& values : bases.values) {
    const std::vector<double> scores = rank_shares(values);
    constexpr double mean = 0.5;
    for (std::size_t f = 0; f + lag < scores.size(); ++f) {
      sum += (scores[f] - mean) * (scores[f + lag] - mean);
      squares += 0.5 * ((scores[f] - mean) * (scores[f] - mean) + (scores[f + lag] - mean) * (scores[f + lag] - mean));
    }
  }
  return squares > 0 ? sum / squares : 0;
}

}  // namespace risorius
