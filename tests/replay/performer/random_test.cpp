#include "replay/performer/random.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace risorius {
namespace {

/// The largest distance between the sample's distribution and the normal one (Kolmogorov & Smirnov), times sqrt(n):
/// above 1.95 once in a thousand samples.
double distance_from_normal(std::vector<double> values) {
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = 0.5 * std::erfc(-values[i] / std::sqrt(2.0));
    worst = std::max(
        {worst, std::abs(expected - static_cast<double>(i) / n), std::abs(expected - static_cast<double>(i + 1) / n)});
  }
  return worst * std::sqrt(n);
}

TEST(Random, BothNormalsAreNormal) {
  Random random(7, 1);
  std::vector<double> polar(400'000), ziggurat(400'000);
  for (double& value : polar) value = random.gaussian();
  for (double& value : ziggurat) value = random.noise();
  EXPECT_LT(distance_from_normal(polar), 1.95);
  EXPECT_LT(distance_from_normal(ziggurat), 1.95);
}

TEST(Random, NoiseHasTheTailsOfANormal) {
  Random random(8, 1);
  constexpr int kDraws = 4'000'000;
  int beyond_three = 0, beyond_tail = 0, positive = 0;
  double fourth = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.noise();
    beyond_three += std::abs(x) > 3;
    beyond_tail += std::abs(x) > 3.7;  // drawn by the tail's own method
    positive += x > 0;
    fourth += x * x * x * x / kDraws;
  }
  EXPECT_NEAR(beyond_three, kDraws * std::erfc(3 / std::sqrt(2.0)), 5 * 104);    // 5 times sqrt(10800)
  EXPECT_NEAR(beyond_tail, kDraws * std::erfc(3.7 / std::sqrt(2.0)), 5 * 29.4);  // 5 times sqrt(862)
  EXPECT_NEAR(positive, kDraws / 2, 5 * 1000);
  EXPECT_NEAR(fourth, 3, 0.03);
}

TEST(Random, StreamsOfOneSeedDiffer) {
  Random a(1, 1), b(1, 2), again(1, 1);
  EXPECT_NE(a.noise(), b.noise());
  again.noise();
  EXPECT_EQ(a.noise(), again.noise());
}

}  // namespace
}  // namespace risorius
