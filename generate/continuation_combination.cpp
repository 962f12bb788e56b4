#include "generate/continuation_combination.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "generate/baselines/linear_autoregression.h"

namespace risorius {
namespace {

// All were chosen with a network that knew the performer alone, on a recorded person (generate/README.md).
constexpr double kMemoryS = 60;
/// Of the first weights, at 50 ms; it grows with the square of the horizon, since far ahead fewer errors are
/// independent of each other.
constexpr double kBelief = 5;
/// Of all AUs' weights against an AU's own errors, likewise.
constexpr double kBeliefInAll = 0.1;
/// In units of s: below, an absolute error counts as a squared one.
constexpr double kLeastError = 0.1;
constexpr float kMostResidual = 1.2F;  ///< no intensity changes by more

/// Where 33, 67, 100 and 133 ms stand among the lags of the features.
constexpr std::array<Eigen::Index, AutoregressionTable::kLags> kAutoregressionLags{1, 3, 5, 6};

using AutoregressionWeights = std::array<float, AutoregressionTable::kLags>;

/// The baseline's own weights, between its horizons as it takes them.
AutoregressionWeights weights_at(const AutoregressionTable& table, double ahead_s) noexcept {
  const auto& horizons = AutoregressionTable::kHorizons;
  const double ahead = std::clamp<double>(ahead_s / AutoregressionTable::kLag_s, 0, horizons.back());
  std::size_t upper = 0;
  while (upper + 1 < horizons.size() && horizons[upper] < ahead) ++upper;
  const double from = upper == 0 ? 0 : horizons[upper - 1];
  const double share = (ahead - from) / (horizons[upper] - from);
  AutoregressionWeights weights{};
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const double low = upper == 0 ? 0 : table.weights[upper - 1][k];
    weights[k] = static_cast<float>(low + share * (table.weights[upper][k] - low));
  }
  return weights;
}

std::array<AutoregressionWeights, ContinuationCombination::kHorizons> weights_at_horizons() noexcept {
  std::array<AutoregressionWeights, ContinuationCombination::kHorizons> all{};
  for (std::size_t h = 0; h < all.size(); ++h)
    all[h] = weights_at(shipped_autoregression(), kContinuationHorizonsMs[h] * 1e-3);
  return all;
}

/// Times kBelief and kBeliefInAll.
double at_horizon(std::size_t horizon) noexcept {
  const double relative = kContinuationHorizonsMs[horizon] / kContinuationHorizonsMs.front();
  return relative * relative;
}

ContinuationCombination::Terms first_weights() noexcept { return {1, 1, 0, 0}; }

}  // namespace

void ContinuationCombination::Belief::clear(const Terms& first) noexcept {
  gram.setZero();
  target.setZero();
  weights = first;
}

void ContinuationCombination::Belief::learn(const Terms& terms, float change, double weight) noexcept {
  const Eigen::Matrix<double, kTerms, 1> column = terms.cast<double>();
  gram.noalias() += weight * column * column.transpose();
  target += weight * static_cast<double>(change) * column;
}

void ContinuationCombination::Belief::forget(double kept) noexcept {
  gram *= kept;
  target *= kept;
}

void ContinuationCombination::Belief::solve(const Terms& prior, double strength) noexcept {
  const Eigen::Matrix<double, kTerms, kTerms> believed =
      gram + strength * Eigen::Matrix<double, kTerms, kTerms>::Identity();
  const Terms solved = believed.ldlt().solve(target + strength * prior.cast<double>()).cast<float>();
  if (solved.allFinite()) weights = solved;
}

ContinuationCombination::ContinuationCombination(std::size_t aus) : own_(aus) {
  for (Belief& belief : shared_) belief.clear(first_weights());
  for (Beliefs& beliefs : own_) beliefs = shared_;
}

ContinuationCombination::Terms ContinuationCombination::terms(const ContinuationFeatures& features, Eigen::Index au,
                                                              std::size_t horizon, float residual) noexcept {
  static const auto kAutoregression = weights_at_horizons();
  const float scale = features.scale(au);
  float autoregression = 0;
  for (std::size_t k = 0; k < kAutoregressionLags.size(); ++k)
    autoregression += kAutoregression[horizon][k] * scale * features.inputs(au, kAutoregressionLags[k]);
  const auto way = static_cast<float>(damped_way(kContinuationHorizonsMs[horizon] * 1e-3));
  return {features.velocity_per_s(au) * way, std::clamp(residual, -kMostResidual, kMostResidual), autoregression,
          -scale * features.inputs(au, 0)};
}

void ContinuationCombination::learn(std::size_t horizon, Eigen::Index au, const Terms& terms, float change,
                                    float scale) noexcept {
  Belief& shared = shared_[horizon];
  const double error = std::abs(change - shared.weights.dot(terms));
  const double weight = 1 / std::max(error, kLeastError * static_cast<double>(scale));
  shared.learn(terms, change, weight);
  own_[static_cast<std::size_t>(au)][horizon].learn(terms, change, weight);
}

void ContinuationCombination::forget(double seconds) noexcept {
  const double kept = std::exp(-std::max(seconds, 0.0) / kMemoryS);
  for (Belief& belief : shared_) belief.forget(kept);
  for (Beliefs& beliefs : own_) {
    for (Belief& belief : beliefs) belief.forget(kept);
  }
}

void ContinuationCombination::solve() noexcept {
  for (std::size_t h = 0; h < kHorizons; ++h) {
    shared_[h].solve(first_weights(), kBelief * at_horizon(h));
    for (Beliefs& beliefs : own_) beliefs[h].solve(shared_[h].weights, kBeliefInAll * at_horizon(h));
  }
}

}  // namespace risorius
