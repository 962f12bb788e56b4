#include "replay/performer/au_wander.h"

#include <algorithm>
#include <cmath>

namespace risorius {

namespace {
constexpr std::uint64_t kStream = 21;
}

AuWander::Filter::Filter(std::size_t count, const Wander& wander, double strength, double rate_hz)
    : keep(std::exp(-1 / (rate_hz * wander.time_constant_s))), first(count, 0), second(count, 0) {
  input = std::sqrt(1 - keep * keep);  // the first filter's variance is 1
  // The second one's is (1 + keep^2) / (1 + keep)^2: the sum of keep^(i + j + |i - j|), times (1 - keep)^2.
  scale = strength * wander.deviation * (1 + keep) / std::sqrt(1 + keep * keep);
}

double AuWander::Filter::step(std::size_t k, Random& random) noexcept {
  first[k] = keep * first[k] + input * random.noise();
  second[k] = keep * second[k] + (1 - keep) * first[k];
  return scale * second[k];
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
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = std::clamp(values[k] + micro_motion_.step(k, random_) + drift_.step(k, random_), 0.0, upper[k]);
}

void AuWander::rewind() noexcept {
  random_ = Random(seed_, kStream);
  for (Filter* filter : {&micro_motion_, &drift_}) {
    std::fill(filter->first.begin(), filter->first.end(), 0.0);
    std::fill(filter->second.begin(), filter->second.end(), 0.0);
  }
}

}  // namespace risorius
