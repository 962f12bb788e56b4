#include "generate/baselines/linear_autoregression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

namespace risorius {
namespace {

using Eigen::Index;

constexpr auto kLagCount = static_cast<Index>(AutoregressionTable::kLags);

}  // namespace

AutoregressionTable fit_autoregression(const AuMatrix& series, double ridge) {
  AutoregressionTable table;
  const Index longest = AutoregressionTable::kHorizons.back();
  if (series.rows() < kLagCount + longest + 1)
    throw std::invalid_argument("fit_autoregression: the series is shorter than lags and horizon together");
  using Square = Eigen::Matrix<double, kLagCount, kLagCount>;
  using Column = Eigen::Matrix<double, kLagCount, 1>;
  for (std::size_t h = 0; h < AutoregressionTable::kHorizons.size(); ++h) {
    const Index ahead = AutoregressionTable::kHorizons[h];
    Square gram = Square::Zero();
    Column target = Column::Zero();
    for (Index au = 0; au < series.cols(); ++au) {
      for (Index t = kLagCount; t + ahead < series.rows(); ++t) {
        Column lagged;
        for (Index k = 0; k < kLagCount; ++k) lagged[k] = double{series(t - k - 1, au)} - series(t, au);
        gram += lagged * lagged.transpose();
        target += lagged * (double{series(t + ahead, au)} - series(t, au));
      }
    }
    gram.diagonal().array() += ridge * gram.trace() / static_cast<double>(kLagCount);
    const Column weights = gram.ldlt().solve(target);
    std::copy(weights.begin(), weights.end(), table.weights[h].begin());
  }
  return table;
}

const AutoregressionTable& shipped_autoregression() noexcept {
  // alex_rom_3.csv (A. Djulin, MIT), 134 s of range of motion, 41 AUs over rest at its own 30 frames/s.
  static constexpr AutoregressionTable kTable{{{{-1.0106, 0.1798, 0.0245, -0.0002},
                                                {-1.6272, 0.3282, 0.0671, -0.0123},
                                                {-1.9121, 0.4516, 0.0527, -0.0043},
                                                {-1.9569, 0.4844, 0.0292, 0.0158},
                                                {-1.9253, 0.4871, -0.0209, 0.0694},
                                                {-1.8919, 0.4947, -0.1022, 0.1513},
                                                {-1.8089, 0.4981, -0.2257, 0.3101},
                                                {-1.7034, 0.5031, -0.3202, 0.4204}}}};
  return kTable;
}

LinearAutoregression::LinearAutoregression(std::vector<double> upper_bound, const AutoregressionTable& table)
    : ContinuationBaseline(std::move(upper_bound)),
      table_(table),
      samples_(au_count()),
      counts_(au_count()),
      lagged_(au_count()) {}

void LinearAutoregression::follow(std::size_t au, double value, double since_s) noexcept {
  auto& samples = samples_[au];
  if (since_s <= 0) counts_[au] = 0;
  std::copy_backward(samples.begin(), samples.end() - 1, samples.end());
  samples[0] = {value, since_s};
  counts_[au] = std::min(counts_[au] + 1, kSamples);

  // Walks back through the samples once; before the first one the value is held.
  std::size_t younger = 0;
  double younger_age_s = 0;
  for (std::size_t k = 0; k < AutoregressionTable::kLags; ++k) {
    const double wanted_s = static_cast<double>(k + 1) * AutoregressionTable::kLag_s;
    while (younger + 1 < counts_[au] && younger_age_s + samples[younger].since_s < wanted_s)
      younger_age_s += samples[younger++].since_s;
    double earlier = samples[younger].value;
    if (younger + 1 < counts_[au]) {
      const double share = (wanted_s - younger_age_s) / samples[younger].since_s;
      earlier += share * (samples[younger + 1].value - earlier);
    }
    lagged_[au][k] = earlier - value;
  }
}

double LinearAutoregression::predicted(std::size_t au, double ahead_s) const noexcept {
  constexpr auto& kHorizons = AutoregressionTable::kHorizons;
  const double ahead = std::clamp<double>(ahead_s / AutoregressionTable::kLag_s, 0, kHorizons.back());
  const auto upper = static_cast<std::size_t>(
      std::distance(kHorizons.begin(), std::lower_bound(kHorizons.begin(), kHorizons.end() - 1, ahead)));
  const double from = upper == 0 ? 0 : kHorizons[upper - 1];
  const double share = (ahead - from) / (kHorizons[upper] - from);
  double value = samples_[au][0].value;
  for (std::size_t k = 0; k < AutoregressionTable::kLags; ++k) {
    const double low = upper == 0 ? 0 : table_.weights[upper - 1][k];
    value += (low + share * (table_.weights[upper][k] - low)) * lagged_[au][k];
  }
  return value;
}

}  // namespace risorius
