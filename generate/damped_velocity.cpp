#include "generate/damped_velocity.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

void require(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("DampedVelocityOptions.{} {} is not in [{}, {}]", name, value, least, most));
}

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

}  // namespace

DampedVelocity::DampedVelocity(std::vector<double> upper_bound, const DampedVelocityOptions& options)
    : upper_bound_(std::move(upper_bound)),
      options_(options),
      moments_(kMoments),
      slopes_(kMoments * (kMoments - 1) / 2),
      observed_(upper_bound_.size()),
      errors_(std::clamp<std::size_t>(upper_bound_.size(), 1, kMaxAus), std::clamp(options.memory_s, 0.1, 1000.0)) {
  require("window_ms", options.window_ms, 1, 1000);
  require("time_constant_ms", options.time_constant_ms, 1, 10000);
  require("memory_s", options.memory_s, 0.1, 1000);
  if (upper_bound_.empty() || upper_bound_.size() > kMaxAus) {
    throw std::invalid_argument(
        fmt::format("DampedVelocity: {} upper bounds, allowed are 1 to {}", upper_bound_.size(), kMaxAus));
  }
  for (const double bound : upper_bound_) {
    if (!(bound > 0 && bound <= 2)) {
      throw std::invalid_argument(fmt::format("DampedVelocity: upper bound {} is not in (0, 2]", bound));
    }
  }
}

void DampedVelocity::reset() noexcept {
  next_ = count_ = 0;
  errors_.reset();
}

void DampedVelocity::observe(const AuFrame& frame) noexcept {
  Moment& now = moments_[next_];
  next_ = (next_ + 1) % kMoments;
  count_ = std::min(count_ + 1, kMoments);
  now.time_ns = frame.header.capture_time_ns;
  for (std::size_t au = 0; au < upper_bound_.size(); ++au) {
    const bool observed = au < frame.count && frame.state[au] == AuState::kObserved;
    now.x[au] = au < frame.count ? static_cast<float>(frame.intensity[au]) : 0;
    now.velocity_per_s[au] = observed ? 0 : std::numeric_limits<float>::quiet_NaN();
    observed_[au] = observed ? now.x[au] : std::numeric_limits<float>::quiet_NaN();
  }
  for (std::size_t au = 0; au < upper_bound_.size(); ++au) {
    if (!std::isnan(now.velocity_per_s[au])) now.velocity_per_s[au] = velocity_of(au);
  }
  errors_.observe(now.time_ns, observed_);
}

float DampedVelocity::velocity_of(std::size_t au) noexcept {
  const auto window_ns = static_cast<std::int64_t>(options_.window_ms * 1e6);
  std::size_t slopes = 0;
  const std::size_t frames = count_;
  for (std::size_t newer = 0; newer < frames; ++newer) {
    for (std::size_t older = newer + 1; older < frames; ++older) {
      const Moment &a = past(older), &b = past(newer);
      if (difference_ns(past(0).time_ns, a.time_ns) > window_ns) break;
      if (std::isnan(a.velocity_per_s[au]) || std::isnan(b.velocity_per_s[au])) continue;
      slopes_[slopes++] = (b.x[au] - a.x[au]) / static_cast<float>(seconds(difference_ns(b.time_ns, a.time_ns)));
    }
  }
  if (slopes == 0) return 0;
  const auto middle = slopes_.begin() + static_cast<std::ptrdiff_t>(slopes / 2);
  std::nth_element(slopes_.begin(), middle, slopes_.begin() + static_cast<std::ptrdiff_t>(slopes));
  if (slopes % 2 == 1) return *middle;
  return (*middle + *std::max_element(slopes_.begin(), middle)) / 2;
}

double DampedVelocity::predicted(const Moment& from, std::size_t au, double ahead_s) const noexcept {
  const double velocity = std::isnan(from.velocity_per_s[au]) ? 0 : from.velocity_per_s[au];
  const double tau_s = options_.time_constant_ms * 1e-3;
  return std::clamp(from.x[au] - velocity * tau_s * std::expm1(-ahead_s / tau_s), 0.0, upper_bound_[au]);
}

void DampedVelocity::predict(Continuation& continuation) noexcept {
  const std::size_t steps = std::min<std::size_t>(continuation.step_count, kMaxContinuationSteps);
  errors_.use_horizons(std::span(continuation.ahead_ns.data(), steps));
  const std::size_t aus = std::min<std::size_t>(continuation.au_count, kMaxAus);
  for (std::size_t step = 0; step < steps; ++step) {
    const double ahead_s = seconds(continuation.ahead_ns[step]);
    for (std::size_t au = 0; au < aus; ++au) {
      continuation.intensity[step][au] = 0;
      continuation.standard_deviation[step][au] = std::numeric_limits<float>::quiet_NaN();
      if (count_ == 0 || au >= upper_bound_.size()) continue;
      continuation.intensity[step][au] = static_cast<float>(predicted(past(0), au, ahead_s));
      if (std::isnan(past(0).velocity_per_s[au])) continue;
      continuation.standard_deviation[step][au] = errors_.deviation(step, au);
    }
  }
  if (count_ > 0) errors_.remember(continuation);
}

}  // namespace risorius
