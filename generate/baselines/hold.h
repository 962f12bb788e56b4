// Continuation by the last value. The named baseline `hold`.
#pragma once

#include "generate/baselines/continuation_baseline.h"

namespace risorius {

class Hold final : public ContinuationBaseline {
 public:
  explicit Hold(std::vector<double> upper_bound) : ContinuationBaseline(std::move(upper_bound)), value_(au_count()) {}
  std::string_view name() const noexcept override { return "hold"; }

 private:
  void follow(std::size_t au, double value, double) noexcept override { value_[au] = value; }
  double predicted(std::size_t au, double) const noexcept override { return value_[au]; }

  std::vector<double> value_;
};

}  // namespace risorius
