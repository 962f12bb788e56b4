#include "replay/performer/au_wander.h"

#include <algorithm>
#include <cmath>

namespace risorius {

namespace {
constexpr std::uint64_t kStream = 21;
constexpr double kStepsPerMemory = 20;  // between steps values are interpolated; that loses 0.1 % of the deviation
}  // namespace

AuWander::Filter::Filter(std::size_t count, const Wander& wander, double strength, double rate_hz)
    : first(count, 0), second(count, 0), from(count, 0), to(count, 0) {
  stride = std::clamp(static_cast<int>(rate_hz * wander.time_constant_s / kStepsPerMemory), 1, 1 << 20);
  keep = std::exp(-stride / (rate_hz * wander.time_constant_s));
  input = std::sqrt(1 - keep * keep);  // the first filter's variance is 1
  // The second one's is (1 + keep^2) / (1 + keep)^2: the sum of keep^(i + j + |i - j|), times (1 - keep)^2.
  scale = strength * wander.deviation * (1 + keep) / std::sqrt(1 + keep * keep);
}

void AuWander::Filter::advance(Random& random) noexcept {
  if (++phase < stride) return;
  phase = 0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    first[k] = keep * first[k] + input * random.noise();
    second[k] = keep * second[k] + (1 - keep) * first[k];
    from[k] = to[k];
    to[k] = scale * second[k];
  }
}

void AuWander::Filter::clear() noexcept {
  for (std::vector<double>* values : {&first, &second, &from, &to}) std::fill(values->begin(), values->end(), 0.0);
  phase = 0;
}

AuWander::AuWander(std::size_t au_count, const Wander& micro_motion, const Wander& drift, double strength,
                   double rate_hz, std::uint64_t seed)
    : is_still_(strength <= 0),
      seed_(seed),
      micro_motion_(au_count, micro_motion, strength, rate_hz),
      drift_(au_count, drift, strength, rate_hz),
      random_(seed, kStream) {}

void AuWander::add_to(std::span<double> values, std::span<const double> upper) noexcept {
  if (is_still_) return;
  micro_motion_.advance(random_);
  drift_.advance(random_);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = std::clamp(values[k] + micro_motion_.value(k) + drift_.value(k), 0.0, upper[k]);
}

void AuWander::rewind() noexcept {
  random_ = Random(seed_, kStream);
  micro_motion_.clear();
  drift_.clear();
}

}  // namespace risorius
