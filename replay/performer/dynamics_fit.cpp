#include "replay/performer/dynamics_fit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "replay/performer/action_fit.h"
#include "replay/performer/au_wander.h"
#include "replay/performer/posture_fit.h"
#include "replay/performer/wander_fit.h"

namespace risorius {
namespace {

constexpr std::size_t kLeastActions = 30;
constexpr double kStep = 0.6;    // of a correction, per round
constexpr double kWidest = 1.1;  // log-normal spread of holds: 90 % within a factor of 6
constexpr double kHighest = 1.15;
constexpr double kMostRepeats = 0.75;                // four in a row; more would show a short take few of the AUs
constexpr double kLeastGain = 0.8, kMostGain = 1.2;  // of followers, whose levels are measured: a correction only
constexpr double kShortMemoryS = 0.5, kLongMemoryS = 2;

/// What simulated moments compare.
struct Moments {
  double velocity_50, velocity_90, duration_50, duration_90, interval_50, interval_90;
  double short_memory, long_memory;
  WanderMoments wander;
};

/// Of several series of the same AUs together.
Moments moments_of(const std::vector<PreparedSeries>& takes) {
  ActionDistributions d;
  Moments moments{};
  const double share = 1 / static_cast<double>(takes.size());
  for (const PreparedSeries& take : takes) {
    append(d, distributions_of(find_actions(take)));
    moments.short_memory += share * posture_memory(take, kShortMemoryS);
    moments.long_memory += share * posture_memory(take, kLongMemoryS);
    const WanderMoments one = wander_moments(take);
    for (double WanderMoments::*value : {&WanderMoments::frame, &WanderMoments::half_second,
                                         &WanderMoments::five_seconds, &WanderMoments::twenty_seconds})
      moments.wander.*value += share * one.*value;
  }
  const auto q = [](const std::vector<double>& v, double at) { return std::max(quantile_of(v, at), 1e-3); };
  moments.velocity_50 = q(d.peak_velocity, 0.5);
  moments.velocity_90 = q(d.peak_velocity, 0.9);
  moments.duration_50 = q(d.duration_s, 0.5);
  moments.duration_90 = q(d.duration_s, 0.9);
  moments.interval_50 = q(d.rest_to_rest_s, 0.5);
  moments.interval_90 = q(d.rest_to_rest_s, 0.9);
  return moments;
}

double log_ratio(double real, double made) {
  return std::clamp(std::log(std::max(real, 1e-12) / std::max(made, 1e-12)), -0.7, 0.7);
}

/// Moves a distribution so that what it makes comes nearer to what was recorded.
void correct(LogNormal& d, double real_50, double real_90, double made_50, double made_90, double least, double most) {
  const double at_50 = log_ratio(real_50, made_50);
  const double at_90 = log_ratio(real_90, made_90);
  d.median = std::clamp(d.median * std::exp(kStep * at_50), least, most);
  d.sigma = std::clamp(d.sigma + kStep * 0.5 * (at_90 - at_50), 0.05, kWidest);
}

/// The median follows the rest within runs of repetitions; the 90th percentile how long the runs are, in which other
/// AUs are left alone, and how far followers come over the threshold.
void correct_rests(Dynamics& dynamics, const Moments& real, const Moments& made) {
  const double at_50 = log_ratio(real.interval_50, made.interval_50);
  const double at_90 = log_ratio(real.interval_90, made.interval_90);
  dynamics.rest_s.median = std::clamp(dynamics.rest_s.median * std::exp(kStep * at_50), 0.05, 20.0);
  const double p = dynamics.repeat_probability;
  const double odds = p / (1 - p) * std::exp(0.5 * kStep * (at_90 - at_50));
  dynamics.repeat_probability = std::clamp(odds / (1 + odds), 0.02, kMostRepeats);
  dynamics.follower_gain = std::clamp(dynamics.follower_gain * std::exp(-0.3 * kStep * at_90), kLeastGain, kMostGain);
}

/// A posture that forgets too fast within half a second is renewed less by a shift; over two seconds, by the next
/// posture.
void correct_memory(Timing& timing, const Moments& real, const Moments& made) {
  timing.shift_renewal = std::clamp(timing.shift_renewal - kStep * (real.short_memory - made.short_memory), 0.05, 0.95);
  timing.persistence = std::clamp(timing.persistence + kStep * (real.long_memory - made.long_memory), 0.0, 0.95);
}

/// Part of what moves at rest are small changes of the posture: the rest of it is wandering. Not less than half of it,
/// because expressions and speech have no postures of the table.
void correct_wandering(Dynamics& dynamics, double least_deviation, const WanderMoments& real,
                       const WanderMoments& made) {
  const double frame = log_ratio(real.frame, made.frame), half = log_ratio(real.half_second, made.half_second);
  Wander& micro = dynamics.micro_motion;
  micro.deviation = std::clamp(micro.deviation * std::exp(0.5 * kStep * half), least_deviation, 0.1);
  micro.time_constant_s = std::clamp(micro.time_constant_s * std::exp(0.5 * kStep * (half - frame)), 0.1, 5.0);
  Wander& drift = dynamics.rest_drift;
  const double five = log_ratio(real.five_seconds, made.five_seconds);
  const double twenty = log_ratio(real.twenty_seconds, made.twenty_seconds);
  drift.deviation = std::clamp(drift.deviation * std::exp(0.5 * kStep * twenty), 1e-5, 0.1);
  drift.time_constant_s = std::clamp(drift.time_constant_s * std::exp(0.5 * kStep * (twenty - five)), 1.0, 100.0);
}

/// The bars' six, which decide which round is kept.
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

std::vector<PreparedSeries> performed_takes(const std::vector<std::string>& names, const Dynamics& dynamics,
                                            double seconds, int takes, std::uint64_t seed) {
  std::vector<PreparedSeries> performed;
  for (int take = 0; take < takes; ++take)
    performed.push_back(prepare_series(
        perform_range_of_motion(names, dynamics, seconds, 1000 * seed + static_cast<std::uint64_t>(take)), 30));
  return performed;
}

}  // namespace

AuSeries perform_range_of_motion(const std::vector<std::string>& names, const Dynamics& dynamics, double seconds,
                                 std::uint64_t seed) {
  return perform_series(names, {ScriptKind::kRom, seconds, seed, true, false}, dynamics);
}

AuSeries perform_series(const std::vector<std::string>& names, const ScriptOptions& options, const Dynamics& dynamics) {
  constexpr double kRateHz = 30;
  PerformerScript script(names, options, dynamics);
  AuWander wander(names.size(), dynamics.micro_motion, dynamics.rest_drift, 1, kRateHz, options.seed);
  const std::vector<double> upper(names.size(), kHighest);
  AuSeries series{.names = names};
  const auto frames = static_cast<std::uint64_t>(options.seconds * kRateHz);
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
  fit_single_actions(recorded, actions, dynamics);
  dynamics.postures = fit_postures(recorded);
  dynamics.timing = fit_timing(recorded, actions);
  dynamics.timing.shift_renewal = 0.5;
  const Moments real = moments_of({recorded});
  const Wander alone = micro_motion_of(real.wander, recorded.rate_hz);
  dynamics.micro_motion = alone;
  dynamics.rest_drift = rest_drift_of(real.wander);

  const double seconds = static_cast<double>(recorded.rows.size()) / recorded.rate_hz;
  Dynamics best = dynamics;
  double nearest = 1e9;
  for (int round = 0; round < options.rounds; ++round) {
    if (progress) progress(round, options.rounds);
    const Moments made = moments_of(performed_takes(recorded.names, dynamics, seconds, options.takes, options.seed));
    const double distance = distance_of(real, made);
    // Early rounds have not settled what the distance does not count.
    if (distance < nearest && 2 * round >= options.rounds - 1) {
      nearest = distance;
      best = dynamics;
    }
    correct(dynamics.peak, real.velocity_50, real.velocity_90, made.velocity_50, made.velocity_90, 0.1, 0.95);
    correct(dynamics.hold_s, real.duration_50, real.duration_90, made.duration_50, made.duration_90, 0.03, 20);
    correct_rests(dynamics, real, made);
    correct_memory(dynamics.timing, real, made);
    correct_wandering(dynamics, 0.5 * alone.deviation, real.wander, made.wander);
  }
  return best;
}

ActionDistributions performed_distributions(const std::vector<std::string>& names, const Dynamics& dynamics,
                                            double seconds, int takes, std::uint64_t seed) {
  ActionDistributions all;
  for (const PreparedSeries& take : performed_takes(names, dynamics, seconds, takes, seed))
    append(all, distributions_of(find_actions(take)));
  return all;
}

}  // namespace risorius
