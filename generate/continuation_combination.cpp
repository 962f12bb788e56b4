#include "generate/continuation_combination.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "generate/baselines/linear_autoregression.h"

namespace risorius {
namespace {

// All three were chosen with a network that knew the performer alone, on a recorded person (generate/README.md).
constexpr double kMemoryS = 60;
/// Of the first weights, at 50 ms; it grows with the square of the horizon, since far ahead fewer errors are
/// independent of each other.
constexpr double kBelief = 5;
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

double belief(std::size_t horizon) noexcept {
  const double relative = kContinuationHorizonsMs[horizon] / kContinuationHorizonsMs.front();
  return kBelief * relative * relative;
}

ContinuationCombination::Terms first_weights() noexcept { return {1, 1, 0, 0}; }

}  // namespace

ContinuationCombination::ContinuationCombination() noexcept {
  weights_.fill(first_weights());
  gram_.fill(Square::Zero());
  target_.fill(Column::Zero());
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

void ContinuationCombination::learn(std::size_t horizon, const Terms& terms, float change, float scale) noexcept {
  const double error = std::abs(change - weights_[horizon].dot(terms));
  const double weight = 1 / std::max(error, kLeastError * static_cast<double>(scale));
  const Column column = terms.cast<double>();
  gram_[horizon].noalias() += weight * column * column.transpose();
  target_[horizon] += weight * static_cast<double>(change) * column;
}

void ContinuationCombination::forget(double seconds) noexcept {
  const double kept = std::exp(-std::max(seconds, 0.0) / kMemoryS);
  for (Square& gram : gram_) gram *= kept;
  for (Column& target : target_) target *= kept;
}

void ContinuationCombination::solve() noexcept {
  const Column first = first_weights().cast<double>();
  for (std::size_t h = 0; h < kHorizons; ++h) {
    const Square believed = gram_[h] + belief(h) * Square::Identity();
    const Terms weights = believed.ldlt().solve(target_[h] + belief(h) * first).cast<float>();
    if (weights.allFinite()) weights_[h] = weights;
  }
}

}  // namespace risorius
