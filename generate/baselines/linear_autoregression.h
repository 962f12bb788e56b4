// Continuation by linear autoregression, one set of weights for all AUs:
//
//   x(t + h) = x(t) + sum_k w_k(h) (x(t - k d) - x(t)),   k = 1 .. 4,  d = 1/30 s
//
// Earlier values are interpolated between frames; w(h) is interpolated between the horizons of the table, from 0 at
// h = 0, and held behind the last. The named baseline `linear_autoregression`.
#pragma once

#include <array>
#include <span>

#include "generate/baselines/continuation_baseline.h"
#include "generate/transition.h"

namespace risorius {

struct AutoregressionTable {
  static constexpr std::size_t kLags = 4;
  static constexpr double kLag_s = 1.0 / 30;
  /// In lags; the weights of each stand in the same row.
  static constexpr std::array<int, 8> kHorizons{1, 2, 3, 4, 6, 8, 12, 15};
  std::array<std::array<double, kLags>, kHorizons.size()> weights{};
};

/// Least squares over every column of `series`, whose rows are one lag apart, with `ridge` times the mean square of the
/// regressors on the diagonal. Throws std::invalid_argument if it is too short.
AutoregressionTable fit_autoregression(const AuMatrix& series, double ridge = 1e-3);

/// Fitted on the range of motion that the performer's dynamics come from (generate/README.md).
const AutoregressionTable& shipped_autoregression() noexcept;

class LinearAutoregression final : public ContinuationBaseline {
 public:
  explicit LinearAutoregression(std::vector<double> upper_bound,
                                const AutoregressionTable& table = shipped_autoregression());
  std::string_view name() const noexcept override { return "linear_autoregression"; }

 private:
  struct Sample {
    double value = 0, since_s = 0;  ///< since the sample before it
  };
  static constexpr std::size_t kSamples = 32;  // more than 4 lags at 60 frames/s
  using Lags = std::array<double, AutoregressionTable::kLags>;

  void follow(std::size_t au, double value, double since_s) noexcept override;
  double predicted(std::size_t au, double ahead_s) const noexcept override;

  AutoregressionTable table_;
  /// Per AU, the youngest first.
  std::vector<std::array<Sample, kSamples>> samples_;
  std::vector<std::size_t> counts_;
  std::vector<Lags> lagged_;  ///< x(t - k d) - x(t)
};

}  // namespace risorius
