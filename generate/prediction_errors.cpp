#include "generate/prediction_errors.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr std::int64_t kLongestInterpolation_ns = 100'000'000;
constexpr double kPriorWeight = 10;       // frames that the prior counts for
constexpr double kPriorGrowth_per_s = 1;  // of the standard deviation with the horizon, before anything was learnt
constexpr double kPriorLargest = 0.3;

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

double prior_variance(double ahead_s) noexcept {
  const double deviation = std::min(kPriorLargest, kPriorGrowth_per_s * ahead_s);
  return deviation * deviation;
}

}  // namespace

PredictionErrors::PredictionErrors(std::size_t aus, double memory_s)
    : aus_(aus),
      memory_s_(memory_s),
      made_ns_(kRemembered),
      predictions_(kRemembered * kMaxContinuationSteps * aus),
      last_(aus),
      errors_(kMaxContinuationSteps * aus) {
  if (aus < 1 || aus > kMaxAus)
    throw std::invalid_argument(fmt::format("PredictionErrors: {} AUs, allowed are 1 to {}", aus, kMaxAus));
  if (!(memory_s >= 0.1 && memory_s <= 1000))
    throw std::invalid_argument(fmt::format("PredictionErrors: memory_s {} is not in [0.1, 1000]", memory_s));
}

void PredictionErrors::reset() noexcept {
  next_ = count_ = 0;
  has_last_ = false;
}

void PredictionErrors::use_horizons(std::span<const std::int64_t> ahead_ns) noexcept {
  const std::size_t steps = std::min(ahead_ns.size(), kMaxContinuationSteps);
  if (steps == step_count_ &&
      std::equal(ahead_ns.begin(), ahead_ns.begin() + static_cast<std::ptrdiff_t>(steps), ahead_ns_.begin()))
    return;
  step_count_ = steps;
  std::copy_n(ahead_ns.begin(), steps, ahead_ns_.begin());
  std::fill(errors_.begin(), errors_.end(), Error{});
  next_ = count_ = 0;
}

void PredictionErrors::observe(std::int64_t time_ns, std::span<const float> intensity) noexcept {
  if (has_last_ && difference_ns(time_ns, last_ns_) <= kLongestInterpolation_ns) {
    for (std::size_t step = 0; step < step_count_; ++step) learn_step(step, time_ns, intensity);
  }
  has_last_ = true;
  last_ns_ = time_ns;
  std::copy_n(intensity.begin(), aus_, last_.begin());
}

/// Scores every prediction whose time lies between the last two frames.
void PredictionErrors::learn_step(std::size_t step, std::int64_t time_ns, std::span<const float> intensity) noexcept {
  const std::int64_t interval_ns = time_ns - last_ns_;  // observe() has seen that it is short
  const double forget = std::exp(-seconds(interval_ns) / memory_s_);
  for (std::size_t back = 0; back < count_; ++back) {
    const std::size_t slot = slot_before(back);
    const std::int64_t past_last_ns = difference_ns(ahead_ns_[step], difference_ns(last_ns_, made_ns_[slot]));
    if (past_last_ns <= 0) break;  // older ones aimed earlier still
    if (past_last_ns > interval_ns) continue;
    const double share = seconds(past_last_ns) / seconds(interval_ns);
    const std::span<const float> predicted = prediction(slot, step);
    for (std::size_t au = 0; au < aus_; ++au) {
      const double actual = last_[au] + share * (intensity[au] - last_[au]);
      const double error = actual - predicted[au];
      if (std::isnan(error)) continue;
      Error& sum = errors_[step * aus_ + au];
      sum.squared_sum = forget * sum.squared_sum + error * error;
      sum.weight = forget * sum.weight + 1;
    }
  }
}

void PredictionErrors::remember(const Continuation& continuation) noexcept {
  const std::size_t steps = std::min<std::size_t>(continuation.step_count, kMaxContinuationSteps);
  use_horizons(std::span(continuation.ahead_ns.data(), steps));
  made_ns_[next_] = last_ns_;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::span<float> kept = prediction(next_, step);
    for (std::size_t au = 0; au < aus_; ++au) {
      const bool known = au < continuation.au_count && !std::isnan(continuation.standard_deviation[step][au]);
      kept[au] = known ? continuation.intensity[step][au] : std::numeric_limits<float>::quiet_NaN();
    }
  }
  next_ = (next_ + 1) % kRemembered;
  count_ = std::min(count_ + 1, kRemembered);
}

float PredictionErrors::deviation(std::size_t step, std::size_t au) const noexcept {
  const Error& error = errors_[step * aus_ + au];
  const double variance =
      (kPriorWeight * prior_variance(seconds(ahead_ns_[step])) + error.squared_sum) / (kPriorWeight + error.weight);
  return static_cast<float>(std::sqrt(variance));
}

}  // namespace risorius
