#include "generate/interpolation.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

using Eigen::Index;

constexpr float kLeast = 0, kMost = 1.2F;
constexpr Index kLongestTransition = 1'000'000;

constexpr std::array<std::string_view, 5> kNames{"hold", "linear", "minimum_jerk", "cubic_hermite", "quintic"};

/// Coefficients of the polynomial in u, the lowest first: 6 of them.
using Polynomial = std::array<double, 6>;

double value_of(const Polynomial& c, double u) noexcept {
  double value = c[5];
  for (std::size_t k = 5; k-- > 0;) value = value * u + c[k];
  return value;
}

/// `velocity` and `acceleration` of the start in units of the whole transition's time.
Polynomial course(InterpolationKind kind, double from, double to, double velocity, double acceleration) noexcept {
  const double way = to - from;
  switch (kind) {
    case InterpolationKind::kHold:
      return {from, 0, 0, 0, 0, 0};
    case InterpolationKind::kLinear:
      return {from, way, 0, 0, 0, 0};
    case InterpolationKind::kMinimumJerk:
      return {from, 0, 0, 10 * way, -15 * way, 6 * way};
    case InterpolationKind::kCubicHermite:
      return {from, velocity, 3 * way - 2 * velocity, velocity - 2 * way, 0, 0};
    case InterpolationKind::kQuintic:
      return {from,
              velocity,
              acceleration / 2,
              10 * way - 6 * velocity - 1.5 * acceleration,
              -15 * way + 8 * velocity + 1.5 * acceleration,
              6 * way - 3 * velocity - acceleration / 2};
  }
  return {from, 0, 0, 0, 0, 0};
}

}  // namespace

void check_transition_request(const TransitionRequest& request) {
  const auto refuse = [](const std::string& why) { throw std::invalid_argument("TransitionRequest: " + why); };
  if (request.past.rows() < 1 || request.past.cols() < 1) refuse("a past without rows or AUs");
  if (request.target.size() != request.past.cols())
    refuse(fmt::format("a target of {} AUs after a past of {}", request.target.size(), request.past.cols()));
  if (request.frames < 1 || request.frames > kLongestTransition)
    refuse(fmt::format("{} frames, allowed are 1 to {}", request.frames, kLongestTransition));
  if (!(request.rate_hz > 0) || !std::isfinite(request.rate_hz))
    refuse(fmt::format("a rate of {} Hz", request.rate_hz));
  if (!request.past.allFinite() || !request.target.allFinite()) refuse("intensities that are not finite");
}

PastMotion motion_at_end(const AuMatrix& past, double rate_hz, double window_ms) {
  const auto in_window = static_cast<Index>(window_ms * 1e-3 * rate_hz + 1e-9) + 1;
  const Index rows = std::min(past.rows(), std::max<Index>(3, in_window));
  const Index order = std::min<Index>(rows, 3);
  PastMotion motion{Eigen::VectorXd::Zero(past.cols()), Eigen::VectorXd::Zero(past.cols())};
  if (order < 2) return motion;
  Eigen::MatrixXd powers(rows, order);
  for (Index row = 0; row < rows; ++row) {
    const double frames_before = static_cast<double>(row - (rows - 1));
    for (Index k = 0; k < order; ++k) powers(row, k) = std::pow(frames_before, k);
  }
  const Eigen::MatrixXd fitted = powers.householderQr().solve(past.bottomRows(rows).cast<double>());
  motion.velocity_per_s = fitted.row(1).transpose() * rate_hz;
  if (order > 2) motion.acceleration_per_s2 = fitted.row(2).transpose() * (2 * rate_hz * rate_hz);
  return motion;
}

Interpolation::Interpolation(InterpolationKind kind, const InterpolationOptions& options)
    : kind_(kind), options_(options) {
  if (!(options.window_ms >= 0 && options.window_ms <= 1000)) {
    throw std::invalid_argument(
        fmt::format("InterpolationOptions.window_ms {} is not in [0, 1000]", options.window_ms));
  }
}

std::string_view Interpolation::name() const noexcept { return kNames[static_cast<std::size_t>(kind_)]; }

void Interpolation::generate(const TransitionRequest& request, AuMatrix& result) {
  check_transition_request(request);
  const double seconds = static_cast<double>(request.frames) / request.rate_hz;
  const PastMotion motion = motion_at_end(request.past, request.rate_hz, options_.window_ms);
  result.resize(request.frames, request.past.cols());
  const auto from = request.past.row(request.past.rows() - 1);
  for (Index au = 0; au < result.cols(); ++au) {
    const Polynomial c = course(kind_, from[au], request.target[au], motion.velocity_per_s[au] * seconds,
                                motion.acceleration_per_s2[au] * seconds * seconds);
    for (Index k = 0; k < request.frames; ++k) {
      const double u = static_cast<double>(k + 1) / static_cast<double>(request.frames);
      result(k, au) = std::clamp(static_cast<float>(value_of(c, u)), kLeast, kMost);
    }
    result(request.frames - 1, au) = std::clamp(request.target[au], kLeast, kMost);  // without the sum's rounding
  }
}

std::unique_ptr<TransitionModel> make_interpolation(std::string_view name) {
  for (const InterpolationKind kind : kInterpolationKinds) {
    if (name == kNames[static_cast<std::size_t>(kind)]) return std::make_unique<Interpolation>(kind);
  }
  return nullptr;
}

}  // namespace risorius
