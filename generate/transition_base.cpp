#include "generate/transition_base.h"

#include <algorithm>
#include <cmath>

#include "generate/end_motion.h"

namespace risorius {
namespace {

constexpr float kFadeS = 0.25F;           ///< the longest tau
constexpr float kLeastFadeS = 1.0F / 30;  ///< a motion is not stopped at once
constexpr float kMostVelocity = 24;       ///< per second; beyond, it is a defect
constexpr float kMostWay = 0.5F;          ///< what a velocity may cover
constexpr float kBeyondTarget = 0.05F;    ///< by so much it may pass the target
/// The same of a velocity that leads away from the target, which the face is going to turn.
constexpr float kFadeAwayS = 0.15F, kMostWayAway = 0.2F;
constexpr float kMostByAcceleration = 0.04F, kMostByJerk = 0.01F;
constexpr float kMostIntensity = 1.2F;
/// A movement that brakes comes to rest after v / a; faded meanwhile, a little later.
constexpr float kStopping = 1.5F;

// The integrals over s of w(s), s w(s) and s^2/2 w(s) from 0 to s, w(s) = 1 - 10 s^3 + 15 s^4 - 6 s^5, and at 1.
constexpr float kVelocityCovers = 0.5F, kAccelerationCovers = 1.0F / 7, kJerkCovers = 5.0F / 168;

float covered_by_velocity(float s) noexcept {
  if (s >= 1) return kVelocityCovers;
  return s - s * s * s * s * (2.5F - s * (3 - s));
}
float covered_by_acceleration(float s) noexcept {
  if (s >= 1) return kAccelerationCovers;
  return s * s * (0.5F - s * s * s * (2 - s * (2.5F - s * 6 / 7)));
}
float covered_by_jerk(float s) noexcept {
  if (s >= 1) return kJerkCovers;
  return s * s * s * (1.0F / 6 - s * s * s * (5.0F / 6 - s * (15.0F / 14 - s * 3 / 8)));
}

/// p(t) of one AU.
float covered(const TransitionBase& base, Eigen::Index au, float t_s) noexcept {
  const float tau = base.velocity_fade_s(au), tau_a = base.acceleration_fade_s(au), tau_j = base.jerk_fade_s(au);
  return base.velocity_per_s(au) * tau * covered_by_velocity(t_s / tau) +
         base.acceleration_per_s2(au) * tau_a * tau_a * covered_by_acceleration(t_s / tau_a) +
         base.jerk_per_s3(au) * tau_j * tau_j * tau_j * covered_by_jerk(t_s / tau_j);
}

/// Between the shortest and the longest that a transition has time for.
struct FadeRange {
  float shortest, longest;
  float clamp(float fade_s) const noexcept { return std::clamp(fade_s, shortest, longest); }
};

/// How soon the velocity is faded: before it passes the target, a bound, or what any velocity may cover.
float velocity_fade(float velocity, float start, float change, const FadeRange& range) noexcept {
  const float speed = std::abs(velocity);
  const float room = velocity > 0 ? kMostIntensity - start : start;
  const bool leads_there = velocity * change > 0;
  const float most = std::min(room, leads_there ? std::min(kMostWay, std::abs(change) + kBeyondTarget) : kMostWayAway);
  const float longest = leads_there ? range.longest : std::min(range.longest, kFadeAwayS);
  return range.clamp(std::min(longest, most / (kVelocityCovers * std::max(speed, 1e-6F))));
}

struct FadedTerm {
  float value = 0, fade_s = 0;
};

/// So soon faded that it covers `most` at most; `power` is that of the time, `covers` its integral's end.
FadedTerm faded_term(double derivative, float power, float covers, float most, const FadeRange& range) noexcept {
  const float largest = most / (covers * std::pow(range.shortest, power));
  const float value = std::clamp(static_cast<float>(derivative), -largest, largest);
  if (value == 0) return {value, range.longest};
  return {value, range.clamp(std::pow(most / (covers * std::abs(value)), 1 / power))};
}

}  // namespace

float minimum_jerk(float u) noexcept { return u * u * u * (10 + u * (6 * u - 15)); }

void make_transition_base(const TransitionRequest& request, TransitionBase& base) {
  const auto seconds = static_cast<float>(static_cast<double>(request.frames) / request.rate_hz);
  const FadeRange range{std::min(seconds, kLeastFadeS), std::min(seconds, kFadeS)};
  base.start = request.past.row(request.past.rows() - 1).transpose();
  base.change = request.target - base.start;
  const Eigen::Index aus = base.start.size();
  for (Eigen::VectorXf* one : {&base.velocity_per_s, &base.acceleration_per_s2, &base.jerk_per_s3,
                               &base.velocity_fade_s, &base.acceleration_fade_s, &base.jerk_fade_s, &base.covered})
    one->resize(aus);
  for (Eigen::Index k = 0; k < aus; ++k) {
    const EndMotion motion = end_motion(request.past, k, request.rate_hz);
    const float velocity = std::clamp(static_cast<float>(motion.velocity_per_s), -kMostVelocity, kMostVelocity);
    float fade_s = velocity_fade(velocity, base.start(k), base.change(k), range);
    const bool brakes = motion.acceleration_per_s2 * double{velocity} < 0;
    float most = kMostByAcceleration;
    if (brakes) {
      const auto stop_s = std::abs(velocity / static_cast<float>(motion.acceleration_per_s2));
      fade_s = std::min(fade_s, range.clamp(kStopping * stop_s));
      // It may take off all that the velocity covers: a lid that closes is stopped within a few frames.
      most = std::max(most, kVelocityCovers * fade_s * std::abs(velocity));
    }
    FadedTerm acceleration = faded_term(motion.acceleration_per_s2, 2, kAccelerationCovers, most, range);
    if (brakes) acceleration.fade_s = std::min(acceleration.fade_s, fade_s);
    const FadedTerm jerk = faded_term(motion.jerk_per_s3, 3, kJerkCovers, kMostByJerk, range);
    base.velocity_per_s(k) = velocity;
    base.velocity_fade_s(k) = fade_s;
    base.acceleration_per_s2(k) = acceleration.value;
    base.acceleration_fade_s(k) = acceleration.fade_s;
    base.jerk_per_s3(k) = jerk.value;
    base.jerk_fade_s(k) = jerk.fade_s;
    base.covered(k) = covered(base, k, seconds);
  }
}

void transition_base_at(const TransitionBase& base, float t_s, float seconds, Eigen::Ref<Eigen::RowVectorXf> row) {
  const float share = minimum_jerk(std::min(t_s / seconds, 1.0F));
  for (Eigen::Index k = 0; k < row.size(); ++k)
    row(k) = base.start(k) + covered(base, k, t_s) + share * (base.change(k) - base.covered(k));
}

}  // namespace risorius
