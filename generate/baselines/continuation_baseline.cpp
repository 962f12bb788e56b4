#include "generate/baselines/continuation_baseline.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLongestGap_ns = 250'000'000;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

const std::vector<double>& checked(const std::vector<double>& upper_bound) {
  if (upper_bound.empty() || upper_bound.size() > kMaxAus) {
    throw std::invalid_argument(
        fmt::format("a continuation of {} AUs, allowed are 1 to {}", upper_bound.size(), kMaxAus));
  }
  for (const double bound : upper_bound) {
    if (!(bound > 0 && bound <= 2))
      throw std::invalid_argument(fmt::format("a continuation's upper bound {} is not in (0, 2]", bound));
  }
  return upper_bound;
}

}  // namespace

ContinuationBaseline::ContinuationBaseline(std::vector<double> upper_bound, double memory_s)
    : upper_bound_(checked(upper_bound)),
      errors_(upper_bound_.size(), memory_s),
      followed_ns_(upper_bound_.size(), kNever) {}

void ContinuationBaseline::reset() noexcept {
  std::fill(followed_ns_.begin(), followed_ns_.end(), kNever);
  errors_.reset();
  has_frame_ = false;
}

void ContinuationBaseline::observe(const AuFrame& frame) noexcept {
  const std::int64_t now_ns = frame.header.capture_time_ns;
  has_frame_ = true;
  for (std::size_t au = 0; au < au_count(); ++au) {
    last_[au] = au < frame.count ? static_cast<float>(frame.intensity[au]) : 0;
    const bool is_observed = au < frame.count && frame.state[au] == AuState::kObserved;
    observed_[au] = is_observed ? last_[au] : kNone;
    if (!is_observed) continue;
    const std::int64_t gap_ns = followed_ns_[au] == kNever ? kNever : difference_ns(now_ns, followed_ns_[au]);
    follow(au, frame.intensity[au], gap_ns > 0 && gap_ns <= kLongestGap_ns ? static_cast<double>(gap_ns) * 1e-9 : 0);
    followed_ns_[au] = now_ns;
  }
  errors_.observe(now_ns, std::span(observed_.data(), au_count()));
}

void ContinuationBaseline::predict(Continuation& continuation) noexcept {
  const std::size_t steps = std::min<std::size_t>(continuation.step_count, kMaxContinuationSteps);
  const std::size_t aus = std::min<std::size_t>(continuation.au_count, kMaxAus);
  errors_.use_horizons(std::span(continuation.ahead_ns.data(), steps));
  for (std::size_t step = 0; step < steps; ++step) {
    const double ahead_s = static_cast<double>(continuation.ahead_ns[step]) * 1e-9;
    for (std::size_t au = 0; au < aus; ++au) {
      const bool known = has_frame_ && au < au_count();
      continuation.intensity[step][au] = known ? last_[au] : 0;
      continuation.standard_deviation[step][au] = kNone;
      if (!known || std::isnan(observed_[au])) continue;
      continuation.intensity[step][au] = static_cast<float>(std::clamp(predicted(au, ahead_s), 0.0, upper_bound_[au]));
      continuation.standard_deviation[step][au] = errors_.deviation(step, au);
    }
  }
  if (has_frame_) errors_.remember(continuation);
}

}  // namespace risorius
