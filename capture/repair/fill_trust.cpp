#include "capture/repair/fill_trust.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace risorius {
namespace {

/// Samples (axes of gaps; all frames of one gap are one) that the first belief is worth.
constexpr double kBeliefSamples = 20;
/// Of the stated deviations up to so many, the half-normal share.
double share_below(double deviations) noexcept { return std::erf(deviations / std::numbers::sqrt2); }
constexpr double kFirstError = 1.0 / 16, kErrorsPerOctave = 3;
const std::array kErrorLimits = [] {
  std::array<double, 32> limits;
  for (std::size_t bin = 0; bin < limits.size(); ++bin) {
    limits[bin] = kFirstError * std::exp2(static_cast<double>(bin) / kErrorsPerOctave);
  }
  return limits;
}();
/// The interval that shall be honest.
constexpr double kInterval = 0.9, kIntervalDeviations = 1.6449;

}  // namespace

FillTrust::FillTrust(double moved) noexcept : away_(kBeliefSamples * moved), towards_(away_), samples_(kBeliefSamples) {
  static_assert(kErrors <= kErrorLimits.size());
  for (std::size_t e = 0; e < kErrors; ++e) errors_[e] = kBeliefSamples * share_below(kErrorLimits[e]);
}

void FillTrust::note_move(double share, const Eigen::Vector3d& moved_mm, const Eigen::Vector3d& right_mm,
                          double variance_mm2) noexcept {
  away_ += share * moved_mm.squaredNorm() / variance_mm2;
  towards_ += share * moved_mm.dot(right_mm) / variance_mm2;
}

void FillTrust::note_error(double share, const Eigen::Vector3d& error_mm, double variance_mm2) noexcept {
  const Eigen::Array3d error = error_mm.array().abs() / std::sqrt(variance_mm2);
  for (std::size_t e = 0; e < kErrors; ++e) {
    errors_[e] += share * static_cast<double>((error <= kErrorLimits[e]).count());
  }
  samples_ += 3 * share;
}

void FillTrust::give_way(const FillTrust& first, double gone) noexcept {
  away_ += gone * (first.away_ - away_);
  towards_ += gone * (first.towards_ - towards_);
  samples_ += gone * (first.samples_ - samples_);
  for (std::size_t e = 0; e < kErrors; ++e) errors_[e] += gone * (first.errors_[e] - errors_[e]);
}

double FillTrust::weight() const noexcept { return std::clamp(towards_ / away_, 0.0, 1.0); }

double FillTrust::scale() const noexcept {
  const double wanted = kInterval * samples_;
  std::size_t e = 1;
  while (e + 1 < kErrors && errors_[e] < wanted) ++e;
  const double below = errors_[e - 1], above = errors_[e];
  const double share = above > below ? std::clamp((wanted - below) / (above - below), 0.0, 1.0) : 1;
  const double limit = kErrorLimits[e - 1] * std::exp2(share / kErrorsPerOctave);
  return limit * limit / (kIntervalDeviations * kIntervalDeviations);
}

}  // namespace risorius
