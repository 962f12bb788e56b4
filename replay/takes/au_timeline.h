// A recorded AU series as a curve over time for other columns at any rate: by name (columns_for), through gaps, and
// without overshoot between samples (monotone cubic, Fritsch & Butland 1984).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "replay/takes/au_series.h"

namespace risorius {

class AuTimeline {
 public:
  /// `rate_hz` of the series, > 0. A column that is not observed anywhere is 0; gaps are bridged, the ends held.
  /// Throws std::invalid_argument for an empty series or a rate that is none.
  AuTimeline(const AuSeries& series, double rate_hz, const std::vector<std::string>& names);

  double seconds() const noexcept { return seconds_; }
  /// Names that the series has nothing for, and columns of the series that no name uses.
  const std::vector<std::string>& masked() const noexcept { return masked_; }
  const std::vector<std::string>& unused() const noexcept { return unused_; }
  /// All values at a time since the first frame; held outside. `values` as many as names.
  void at(double time_s, std::span<double> values) const noexcept;

 private:
  std::size_t width_;
  double rate_hz_, seconds_ = 0;
  std::vector<double> grid_;    ///< frames x names, on the uniform grid
  std::vector<double> slopes_;  ///< per grid step
  std::vector<std::string> masked_, unused_;
};

}  // namespace risorius
