#include "generate/transition_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "generate/end_motion.h"

namespace risorius {
namespace {

constexpr double kPastStepS = 0.02;
constexpr float kFadeS = 0.25F;           ///< tau
constexpr float kLeastFadeS = 1.0F / 30;  ///< of acceleration and jerk
constexpr float kMostVelocity = 24;       ///< per second; beyond, it is a defect
constexpr float kMostWay = 0.5F;          ///< what a velocity may add; a lid that closes at 20/s is soon closed
constexpr float kMostAdded = 0.05F;       ///< what acceleration and jerk each may add until they are faded
constexpr float kFadedWay = 0.27F;        ///< the most of s w(s): what a velocity adds, in units of itself and tau
constexpr float kShareOfLargest = 0.2F, kLeastScale = 0.02F;

/// 1 to 0 with two zero derivatives at both ends.
float fade(float s) noexcept { return s >= 1 ? 0 : 1 - minimum_jerk(s); }

/// A derivative of the start, and how soon it is faded so that it adds at most `most_added` until then.
struct FadedTerm {
  float value = 0, fade_s = 0;
};

/// `power`: that of the time, `divisor`: its factorial.
FadedTerm faded_term(double derivative, int power, float divisor, float seconds, float most_added) noexcept {
  const float longest = std::min(seconds, kFadeS), shortest = std::min(seconds, kLeastFadeS);
  const float most = most_added * divisor / std::pow(shortest, static_cast<float>(power));
  const float value = std::clamp(static_cast<float>(derivative), -most, most);
  const float fade_s =
      value == 0 ? longest : std::pow(most_added * divisor / std::abs(value), 1 / static_cast<float>(power));
  return {value, std::clamp(fade_s, shortest, longest)};
}

}  // namespace

float minimum_jerk(float u) noexcept { return u * u * u * (10 + u * (6 * u - 15)); }

float transition_envelope(float u) noexcept {
  const float p = u * (1 - u);
  return 64 * p * p * p;
}

void transition_spline(float u, Eigen::Ref<Eigen::VectorXf> weights) noexcept {
  weights.setZero();
  const float place = std::clamp(u, 0.0F, 1.0F) * static_cast<float>(kTransitionKnots - 3);
  const auto first = std::min<Eigen::Index>(static_cast<Eigen::Index>(place), kTransitionKnots - 4);
  const float t = place - static_cast<float>(first), s = 1 - t;
  weights(first) = s * s * s / 6;
  weights(first + 1) = (4 + t * t * (3 * t - 6)) / 6;
  weights(first + 2) = (4 + s * s * (3 * s - 6)) / 6;
  weights(first + 3) = t * t * t / 6;
}

void transition_step_inputs(Eigen::Index knot, float seconds, Eigen::Ref<Eigen::VectorXf> inputs) noexcept {
  // Coefficient k of the spline counts most at (k - 1) / (knots - 3).
  const float u = std::clamp(static_cast<float>(knot - 1) / static_cast<float>(kTransitionKnots - 3), 0.0F, 1.0F);
  inputs << 2 * u - 1, 4 * u * (1 - u), std::min((1 - u) * seconds, 4.0F), minimum_jerk(u);
}

void transition_base(const TransitionFeatures& features, float t_s, float seconds, Eigen::Ref<Eigen::RowVectorXf> row) {
  row = (features.start + minimum_jerk(std::min(t_s / seconds, 1.0F)) * features.change).transpose();
  for (Eigen::Index k = 0; k < row.size(); ++k)
    row(k) += t_s * features.velocity_per_s(k) * fade(t_s / features.velocity_fade_s(k)) +
              t_s * t_s *
                  (features.acceleration_per_s2(k) / 2 * fade(t_s / features.acceleration_fade_s(k)) +
                   t_s * features.jerk_per_s3(k) / 6 * fade(t_s / features.jerk_fade_s(k)));
}

TransitionFeatureMaker::TransitionFeatureMaker(const std::vector<std::string>& names) : other_(other_sides(names)) {
  for (const std::string& name : names) kinds_.push_back(kind_of_au(name));
}

void TransitionFeatureMaker::check(const TransitionRequest& request) const {
  const auto width = static_cast<Eigen::Index>(size());
  if (request.past.rows() < 1 || request.past.cols() != width || request.target.size() != width)
    throw std::invalid_argument(fmt::format("TransitionRequest: past {} x {}, target {}; the model has {} AUs",
                                            request.past.rows(), request.past.cols(), request.target.size(), width));
  if (!request.past.allFinite() || !request.target.allFinite())
    throw std::invalid_argument("TransitionRequest: an intensity is not finite");
  if (request.frames < 1 || !(request.rate_hz > 0) || !std::isfinite(request.rate_hz))
    throw std::invalid_argument(
        fmt::format("TransitionRequest: {} frames at {} per second", request.frames, request.rate_hz));
}

void TransitionFeatureMaker::make(const TransitionRequest& request, TransitionFeatures& features) const {
  check(request);
  const auto width = static_cast<Eigen::Index>(size());
  const auto seconds = static_cast<float>(static_cast<double>(request.frames) / request.rate_hz);
  const float tau = std::min(seconds, kFadeS);
  features.start = request.past.row(request.past.rows() - 1).transpose();
  features.change = request.target - features.start;
  features.velocity_per_s.resize(width);
  for (Eigen::VectorXf* one : {&features.velocity_fade_s, &features.acceleration_per_s2, &features.acceleration_fade_s,
                               &features.jerk_per_s3, &features.jerk_fade_s})
    one->resize(width);
  for (Eigen::Index k = 0; k < width; ++k) {
    const EndMotion motion = end_motion(request.past, k, request.rate_hz);
    features.velocity_per_s(k) = std::clamp(static_cast<float>(motion.velocity_per_s), -kMostVelocity, kMostVelocity);
    const float velocity = features.velocity_per_s(k);
    features.velocity_fade_s(k) = std::min(tau, kMostWay / (kFadedWay * std::max(std::abs(velocity), 1e-6F)));
    // What brakes may take off all that the velocity adds: a lid that closes is stopped within a few frames.
    const bool brakes = motion.acceleration_per_s2 * double{velocity} < 0;
    const float most_added =
        brakes ? std::max(kMostAdded, kFadedWay * features.velocity_fade_s(k) * std::abs(velocity)) : kMostAdded;
    const FadedTerm acceleration = faded_term(motion.acceleration_per_s2, 2, 2, seconds, most_added),
                    jerk = faded_term(motion.jerk_per_s3, 3, 6, seconds, kMostAdded);
    features.acceleration_per_s2(k) = acceleration.value;
    features.acceleration_fade_s(k) = acceleration.fade_s;
    features.jerk_per_s3(k) = jerk.value;
    features.jerk_fade_s(k) = jerk.fade_s;
  }
  const Eigen::VectorXf ways = features.change.cwiseAbs();
  const float largest = ways.maxCoeff(), mean = ways.mean();
  features.scale =
      (ways.array().square() + kShareOfLargest * kShareOfLargest * largest * largest + kLeastScale * kLeastScale)
          .sqrt();
  std::array<float, kAuKinds> of_kind{};
  for (Eigen::Index k = 0; k < width; ++k) {
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(k)]);
    if (kind >= kAuKinds) continue;
    of_kind[kind] = std::max(of_kind[kind], ways(k));
  }
  features.fixed.setZero(width, kTransitionFixedWidth);
  for (Eigen::Index k = 0; k < width; ++k) {
    const auto other = static_cast<Eigen::Index>(other_[static_cast<std::size_t>(k)]);
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(k)]);
    auto row = features.fixed.row(k);
    row.head(9) << features.change(k) / features.scale(k), ways(k), features.start(k), request.target(k),
        std::log(seconds), largest, 10 * mean,
        std::clamp(features.velocity_per_s(k) * tau / features.scale(k), -3.0F, 3.0F),
        features.change(other) / features.scale(other);
    if (kind < kAuKinds) row(9 + static_cast<Eigen::Index>(kind)) = 1;
    for (std::size_t i = 0; i < kAuKinds; ++i) row(14 + static_cast<Eigen::Index>(i)) = of_kind[i];
  }
  features.whole.resize(kTransitionWholeWidth);
  features.whole << largest, 10 * mean, features.velocity_per_s.cwiseAbs().maxCoeff(), of_kind[0], of_kind[1],
      of_kind[2], of_kind[3], of_kind[4], static_cast<float>((ways.array() > 0.1F).count()) / 10;
  make_past(request, features);
}

void TransitionFeatureMaker::make_past(const TransitionRequest& request, TransitionFeatures& features) const {
  const auto width = static_cast<Eigen::Index>(size());
  const Eigen::Index last = request.past.rows() - 1;
  features.past.resize(width, kTransitionPastSteps * kTransitionPastWidth);
  for (Eigen::Index step = 0; step < kTransitionPastSteps; ++step) {
    const double back_s = kPastStepS * static_cast<double>(kTransitionPastSteps - 1 - step);
    const double place = std::max(0.0, static_cast<double>(last) - back_s * request.rate_hz);
    const auto before = std::min(static_cast<Eigen::Index>(place), last);
    const Eigen::Index after = std::min(before + 1, last);
    const auto share = static_cast<float>(place - static_cast<double>(before));
    for (Eigen::Index k = 0; k < width; ++k) {
      const auto moved = [&](Eigen::Index column) {
        const float x =
            request.past(before, column) + share * (request.past(after, column) - request.past(before, column));
        return std::clamp((x - features.start(column)) / features.scale(column), -3.0F, 3.0F);
      };
      features.past(k, step * kTransitionPastWidth) = moved(k);
      features.past(k, step * kTransitionPastWidth + 1) =
          moved(static_cast<Eigen::Index>(other_[static_cast<std::size_t>(k)]));
    }
  }
}

}  // namespace risorius
