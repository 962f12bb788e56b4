#include "daemon/latency_histogram.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

TEST(LatencyHistogram, QuantilesAreWithinABucketOfTheTruth) {
  LatencyHistogram histogram;
  for (int us = 1; us <= 10'000; ++us) histogram.add(us * 1000);
  constexpr double kBucketWidth = 1.045;  // 2^(1/16)
  for (const double quantile : {0.1, 0.5, 0.9, 0.99}) {
    EXPECT_GE(histogram.quantile_us(quantile), 10'000 * quantile * 0.999);
    EXPECT_LE(histogram.quantile_us(quantile), 10'000 * quantile * kBucketWidth);
  }
  EXPECT_EQ(histogram.max_us(), 10'000);
  EXPECT_EQ(histogram.quantile_us(1), 10'000);
}

TEST(LatencyHistogram, TakesNothingNegativeAndHuge) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.quantile_us(0.5), 0);
  histogram.add(-5);
  histogram.add(INT64_MAX);
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_GT(histogram.quantile_us(1), 1e7);
}

}  // namespace
}  // namespace risorius
