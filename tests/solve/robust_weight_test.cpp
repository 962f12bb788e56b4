#include "solve/robust_weight.h"

#include <gtest/gtest.h>
#include <vector>

namespace risorius {
namespace {

TEST(RobustWeight, IsOneUpToTheThresholdAndFallsContinuously) {
  for (const int power : {1, 2, 4}) {
    double previous = 1;
    for (double distance = 0; distance < 100; distance += 0.01) {
      const double weight = robust_weight(distance, 2.5, power);
      if (distance <= 2.5) {
        EXPECT_EQ(weight, 1);
      }
      EXPECT_LE(weight, previous);
      EXPECT_LT(previous - weight, 0.02);
      previous = weight;
    }
  }
}

TEST(RobustWeight, InfluenceIsConstantForPowerOneAndVanishesForPowerFour) {
  EXPECT_NEAR(20 * robust_weight(20, 2.5, 1), 2.5, 1e-12);
  EXPECT_NEAR(20 * robust_weight(20, 2.5, 4), 2.5 * 2.5 * 2.5 * 2.5 / (20 * 20 * 20), 1e-12);
}

TEST(LowerMedian, IsTheLowerOfTwoMiddleValues) {
  std::vector<double> none, odd{3, 1, 2}, even{4, 1, 3, 2};
  EXPECT_EQ(lower_median(none), 0);
  EXPECT_EQ(lower_median(odd), 2);
  EXPECT_EQ(lower_median(even), 2);
}

}  // namespace
}  // namespace risorius
