// What a continuation learns of the person before it: how much to believe each of four ways of going on. Per AU and
// horizon h,
//
//   x(t + h) = x(t) + w1 v tau (1 - exp(-h / tau)) + w2 s g(h) + w3 AR(h) + w4 (x(t) - x(t - 17 ms))              (3b)
//
// damped velocity, the network's residual, the linear autoregression's change, the newest step. w begins at (1, 1, 0,
// 0) and follows the least absolute errors of the predictions whose time has passed (iteratively reweighted least
// squares, recursively; combination of forecasts after Bates & Granger 1969): first those of all AUs together, then,
// from there, those of the AU. Allocates nothing after its construction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "generate/continuation_features.h"

namespace risorius {

class ContinuationCombination {
 public:
  static constexpr Eigen::Index kTerms = 4;
  static constexpr std::size_t kHorizons = kContinuationHorizonsMs.size();
  using Terms = Eigen::Matrix<float, kTerms, 1>;

  /// `aus`: how many.
  explicit ContinuationCombination(std::size_t aus);

  /// The terms of (3b) of one AU; `residual` is s g(h), in intensities.
  static Terms terms(const ContinuationFeatures& features, Eigen::Index au, std::size_t horizon,
                     float residual) noexcept;
  /// The prediction's change against the present value.
  float change(std::size_t horizon, Eigen::Index au, const Terms& terms) const noexcept {
    return weights(horizon, au).dot(terms);
  }
  /// What came `horizon` after `terms`: the change, and the AU's scale s then, > 0. Counts from the next solve() on.
  void learn(std::size_t horizon, Eigen::Index au, const Terms& terms, float change, float scale) noexcept;
  /// Time has passed; older errors count less.
  void forget(double seconds) noexcept;
  void solve() noexcept;
  const Terms& weights(std::size_t horizon, Eigen::Index au) const noexcept {
    return own_[static_cast<std::size_t>(au)][horizon].weights;
  }

 private:
  /// Normal equations, and the weights that they gave last.
  struct Belief {
    Eigen::Matrix<double, kTerms, kTerms> gram;
    Eigen::Matrix<double, kTerms, 1> target;
    Terms weights;

    void clear(const Terms& first) noexcept;
    void learn(const Terms& terms, float change, double weight) noexcept;
    void forget(double kept) noexcept;
    void solve(const Terms& prior, double strength) noexcept;
  };
  using Beliefs = std::array<Belief, kHorizons>;

  Beliefs shared_;
  std::vector<Beliefs> own_;  ///< per AU
};

}  // namespace risorius
