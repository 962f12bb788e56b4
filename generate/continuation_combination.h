// What a continuation learns of the person before it: how much to believe each of four ways of going on. Per horizon h
// and for all AUs together,
//
//   x(t + h) = x(t) + w1 v tau (1 - exp(-h / tau)) + w2 s g(h) + w3 AR(h) + w4 (x(t) - x(t - 17 ms))              (3b)
//
// damped velocity, the network's residual, the linear autoregression's change, the newest step. w begins at (1, 1, 0,
// 0) and follows the least absolute errors of the predictions whose time has passed (iteratively reweighted least
// squares, recursively; combination of forecasts after Bates & Granger 1969). Allocates nothing.
#pragma once

#include <Eigen/Core>
#include <array>

#include "generate/continuation_features.h"

namespace risorius {

class ContinuationCombination {
 public:
  static constexpr Eigen::Index kTerms = 4;
  static constexpr std::size_t kHorizons = kContinuationHorizonsMs.size();
  using Terms = Eigen::Matrix<float, kTerms, 1>;

  ContinuationCombination() noexcept;

  /// The terms of (3b) of one AU; `residual` is s g(h), in intensities.
  static Terms terms(const ContinuationFeatures& features, Eigen::Index au, std::size_t horizon,
                     float residual) noexcept;
  /// The prediction's change against the present value.
  float change(std::size_t horizon, const Terms& terms) const noexcept { return weights_[horizon].dot(terms); }
  /// What came `horizon` after `terms`: the change, and the AU's scale s then, > 0. Counts from the next solve() on.
  void learn(std::size_t horizon, const Terms& terms, float change, float scale) noexcept;
  /// Time has passed; older errors count less.
  void forget(double seconds) noexcept;
  void solve() noexcept;
  const Terms& weights(std::size_t horizon) const noexcept { return weights_[horizon]; }

 private:
  using Square = Eigen::Matrix<double, kTerms, kTerms>;
  using Column = Eigen::Matrix<double, kTerms, 1>;

  std::array<Terms, kHorizons> weights_;
  std::array<Square, kHorizons> gram_;
  std::array<Column, kHorizons> target_;
};

}  // namespace risorius
