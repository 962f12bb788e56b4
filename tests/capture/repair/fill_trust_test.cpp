#include "capture/repair/fill_trust.h"

#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

TEST(FillTrust, BeginsWithAllOfTheMoveAndTheStatedVariance) {
  for (const double moved : {0.25, 1.0, 16.0}) {
    const FillTrust trust(moved);
    EXPECT_EQ(trust.weight(), 1);
    EXPECT_NEAR(trust.scale(), 1, 0.05);
  }
}

TEST(FillTrust, LearnsWhichShareOfAMoveWasRightAndWhatTheVarianceIsWorth) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, 1);
  const auto draw = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  FillTrust trust;
  for (int k = 0; k < 5000; ++k) {
    const Eigen::Vector3d moved = 2 * draw();
    trust.note_move(1, moved, 0.3 * moved + 0.5 * draw(), 4);
    trust.note_error(1, 3 * draw(), 4);  // a deviation of 3, where 2 is stated
  }
  EXPECT_NEAR(trust.weight(), 0.3, 0.02);
  EXPECT_NEAR(trust.scale(), 9.0 / 4, 0.15);
  for (int k = 0; k < 200; ++k) trust.give_way(FillTrust(), 0.1);
  EXPECT_NEAR(trust.weight(), 1, 1e-3);
  EXPECT_NEAR(trust.scale(), 1, 0.05);
}

TEST(FillTrust, MakesThe90PercentIntervalHonestWhateverTheErrorsLookLike) {
  std::mt19937_64 random(8);
  std::exponential_distribution<double> exponential(1);
  FillTrust trust;
  const auto draw = [&] { return exponential(random); };
  for (int k = 0; k < 20'000; ++k) trust.note_error(1, {draw(), -draw(), draw()}, 1);
  const double half_width = 1.6449 * std::sqrt(trust.scale());
  EXPECT_NEAR(1 - std::exp(-half_width), 0.9, 0.01);  // the share of such errors below it
}

}  // namespace
}  // namespace risorius
