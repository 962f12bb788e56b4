#include "replay/evaluation/continuation_score.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace risorius {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(ContinuationScore, AveragesWithinAnAuFirstAndThenOverAus) {
  ContinuationScore score(1, 3);
  score.add(0, 0, 0.5, 0.1, 0.4);  // errors 0.1, 0.3
  score.add(0, 0, 0.5, 0.1, 0.8);
  score.add(0, 1, 0.2, 0.1, 0.2);  // 0
  score.add(0, 2, 0.0, 0.1, 1.0);  // not asked for
  EXPECT_NEAR(score.mae(0, 0), 0.2, 1e-12);
  EXPECT_NEAR(score.mae(0, {0, 1}), 0.1, 1e-12);
  EXPECT_EQ(score.count(0, 0), 2u);
}

TEST(ContinuationScore, CoverageIsTheShareWithinNinetyPercentIntervals) {
  ContinuationScore score(2, 1);
  score.add(1, 0, 0, 0.1, 0.16);   // 1.6 deviations: within 1.645
  score.add(1, 0, 0, 0.1, -0.17);  // beyond
  score.add(1, 0, 0, kNone, 9);    // nothing stated
  EXPECT_NEAR(score.coverage(1, {0}), 0.5, 1e-12);
}

TEST(ContinuationScore, WhatWasNotObservedDoesNotCount) {
  ContinuationScore score(1, 1);
  score.add(0, 0, 0.5, 0.1, kNone);
  score.add(0, 0, kNone, 0.1, 0.5);
  EXPECT_EQ(score.count(0, 0), 0u);
  EXPECT_TRUE(std::isnan(score.mae(0, 0)));
}

TEST(AusThatMove, NeedMoreThanATenthBetweenThePercentiles) {
  std::vector<std::vector<double>> series;
  for (int row = 0; row < 1000; ++row) {
    const double ramp = row / 999.0;
    // One outlier is no motion; 0.09 of 98 % are too little, 0.11 enough.
    series.push_back({row == 500 ? 1.0 : 0.0, 0.09 / 0.98 * ramp, 0.11 / 0.98 * ramp, kNone, row % 2 ? kNone : ramp});
  }
  EXPECT_EQ(aus_that_move(series), (std::vector<std::size_t>{2, 4}));
  EXPECT_TRUE(aus_that_move({}).empty());
}

}  // namespace
}  // namespace risorius
