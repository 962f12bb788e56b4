#include "replay/evaluation/continuation_score.h"

#include <algorithm>
#include <cmath>

namespace risorius {
namespace {

constexpr double k90Percent = 1.6448536;  // of the normal distribution, both sides
constexpr double kLeastSpread = 0.1;

}  // namespace

ContinuationScore::ContinuationScore(std::size_t horizons, std::size_t aus) : aus_(aus), sums_(horizons * aus) {}

void ContinuationScore::add(std::size_t horizon, std::size_t au, double predicted, double deviation,
                            double actual) noexcept {
  const double error = std::abs(predicted - actual);
  if (std::isnan(error)) return;
  Sum& sum = sums_[horizon * aus_ + au];
  sum.absolute += error;
  ++sum.count;
  if (std::isnan(deviation)) return;
  ++sum.stated;
  if (error <= k90Percent * deviation) ++sum.within;
}

double ContinuationScore::mae(std::size_t horizon, std::size_t au) const noexcept {
  return at(horizon, au).absolute / static_cast<double>(at(horizon, au).count);
}

double ContinuationScore::mae(std::size_t horizon, const std::vector<std::size_t>& aus) const noexcept {
  double sum = 0;
  for (const std::size_t au : aus) sum += mae(horizon, au);
  return sum / static_cast<double>(aus.size());
}

double ContinuationScore::coverage(std::size_t horizon, const std::vector<std::size_t>& aus) const noexcept {
  double within = 0, stated = 0;
  for (const std::size_t au : aus) {
    within += static_cast<double>(at(horizon, au).within);
    stated += static_cast<double>(at(horizon, au).stated);
  }
  return within / stated;
}

std::vector<std::size_t> aus_that_move(const std::vector<std::vector<double>>& series) {
  std::vector<std::size_t> moving;
  const std::size_t width = series.empty() ? 0 : series.front().size();
  for (std::size_t au = 0; au < width; ++au) {
    std::vector<double> values;
    for (const auto& row : series) {
      if (!std::isnan(row[au])) values.push_back(row[au]);
    }
    if (values.empty()) continue;
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
    };
    if (at(0.99) - at(0.01) > kLeastSpread) moving.push_back(au);
  }
  return moving;
}

}  // namespace risorius
