#include "generate/transition_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kPastStepS = 0.02;
constexpr float kAnnouncedS = 0.25F;  ///< a velocity is told as the way that it makes until then
/// Of the corpora. Of a face with few columns, a mean over these would be larger than any face's.
constexpr float kUsualAus = 41;
constexpr float kShareOfLargest = 0.2F, kLeastScale = 0.02F;

}  // namespace

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
  make_transition_base(request, features.base);
  const TransitionBase& base = features.base;
  const Eigen::VectorXf ways = base.change.cwiseAbs();
  const float largest = ways.maxCoeff(), together = ways.sum() / kUsualAus;
  features.scale =
      (ways.array().square() + kShareOfLargest * kShareOfLargest * largest * largest + kLeastScale * kLeastScale)
          .sqrt();
  std::array<float, kAuKinds> of_kind{};
  for (Eigen::Index k = 0; k < width; ++k) {
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(k)]);
    if (kind >= kAuKinds) continue;
    of_kind[kind] = std::max(of_kind[kind], ways(k));
  }
  const float announced_s = std::min(seconds, kAnnouncedS);
  features.fixed.setZero(width, kTransitionFixedWidth);
  for (Eigen::Index k = 0; k < width; ++k) {
    const auto other = static_cast<Eigen::Index>(other_[static_cast<std::size_t>(k)]);
    const auto kind = static_cast<std::size_t>(kinds_[static_cast<std::size_t>(k)]);
    auto row = features.fixed.row(k);
    row.head(9) << base.change(k) / features.scale(k), ways(k), base.start(k), request.target(k), std::log(seconds),
        largest, 10 * together, std::clamp(base.velocity_per_s(k) * announced_s / features.scale(k), -3.0F, 3.0F),
        base.change(other) / features.scale(other);
    if (kind < kAuKinds) row(9 + static_cast<Eigen::Index>(kind)) = 1;
    for (std::size_t i = 0; i < kAuKinds; ++i) row(14 + static_cast<Eigen::Index>(i)) = of_kind[i];
  }
  features.whole.resize(kTransitionWholeWidth);
  features.whole << largest, 10 * together, base.velocity_per_s.cwiseAbs().maxCoeff(), of_kind[0], of_kind[1],
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
        return std::clamp((x - features.base.start(column)) / features.scale(column), -3.0F, 3.0F);
      };
      features.past(k, step * kTransitionPastWidth) = moved(k);
      features.past(k, step * kTransitionPastWidth + 1) =
          moved(static_cast<Eigen::Index>(other_[static_cast<std::size_t>(k)]));
    }
  }
}

}  // namespace risorius
