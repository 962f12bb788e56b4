// How good predictions ahead are: errors per AU and horizon against what came, and how honest their standard deviations
// are. Fed with pairs of predicted and actual values; which pairs are fair (the source's own samples only) is the
// caller's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace risorius {

class ContinuationScore {
 public:
  ContinuationScore(std::size_t horizons, std::size_t aus);

  /// A value that is NaN was not observed, and does not count; `deviation` NaN: not stated.
  void add(std::size_t horizon, std::size_t au, double predicted, double deviation, double actual) noexcept;

  /// Mean absolute error; NaN if nothing was added.
  double mae(std::size_t horizon, std::size_t au) const noexcept;
  /// Mean over these AUs of their mean absolute errors.
  double mae(std::size_t horizon, const std::vector<std::size_t>& aus) const noexcept;
  /// Share of the errors within the 90 % interval +-1.645 deviations, of those that stated one.
  double coverage(std::size_t horizon, const std::vector<std::size_t>& aus) const noexcept;
  std::uint64_t count(std::size_t horizon, std::size_t au) const noexcept { return at(horizon, au).count; }

 private:
  struct Sum {
    double absolute = 0;
    std::uint64_t count = 0, within = 0, stated = 0;
  };
  const Sum& at(std::size_t horizon, std::size_t au) const noexcept { return sums_[horizon * aus_ + au]; }

  std::size_t aus_;
  std::vector<Sum> sums_;
};

/// Columns of a series (rows of values, NaN = not observed) whose 99th and 1st percentile are more than 0.1 apart.
std::vector<std::size_t> aus_that_move(const std::vector<std::vector<double>>& series);

}  // namespace risorius
