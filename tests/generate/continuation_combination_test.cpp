#include "generate/continuation_combination.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "support/allocation_counter.h"

namespace risorius {
namespace {

using Terms = ContinuationCombination::Terms;

Terms drawn_terms(std::mt19937_64& random) {
  std::normal_distribution<float> normal(0, 0.05F);
  return {normal(random), normal(random), normal(random), normal(random)};
}

TEST(ContinuationCombination, BeginsWithDampedVelocityAndTheNetworksResidual) {
  ContinuationCombination combination(2);
  for (std::size_t h = 0; h < ContinuationCombination::kHorizons; ++h)
    EXPECT_FLOAT_EQ(combination.change(h, 1, {0.1F, 0.02F, 5, 7}), 0.12F);
}

TEST(ContinuationCombination, FindsTheWeightsThatAPersonFollowsWhateverTheOutliers) {
  ContinuationCombination combination(2);
  std::mt19937_64 random(3);
  const Terms truth{0.3F, 0.8F, 0.4F, -0.2F};
  for (int i = 0; i < 20'000; ++i) {
    const Terms terms = drawn_terms(random);
    // One change in twenty is none of this: a blink.
    const float change = i % 20 == 0 ? 0.7F : truth.dot(terms);
    for (std::size_t h = 0; h < ContinuationCombination::kHorizons; ++h) combination.learn(h, 0, terms, change, 0.05F);
    if (i % 100 == 0) combination.solve();
  }
  combination.solve();
  for (Eigen::Index k = 0; k < ContinuationCombination::kTerms; ++k) {
    EXPECT_NEAR(combination.weights(0, 0)(k), truth(k), 0.02) << k;
    EXPECT_NEAR(combination.weights(4, 0)(k), truth(k), 0.15)
        << k << ": at 500 ms the first weights are left more slowly";
  }
}

TEST(ContinuationCombination, AnAuThatGoesOnInItsOwnWayIsFoundAndTheOthersServeOneThatHasNotMoved) {
  ContinuationCombination combination(3);
  std::mt19937_64 random(4);
  const Terms first{0.2F, 0.5F, 0.7F, 0.1F}, second{0.2F, 0.5F, -0.3F, 0.1F};
  for (int i = 0; i < 10'000; ++i) {
    const Terms terms = drawn_terms(random);
    combination.learn(0, 0, terms, first.dot(terms), 0.05F);
    combination.learn(0, 1, terms, second.dot(terms), 0.05F);
    if (i % 100 == 0) combination.solve();
  }
  combination.solve();
  EXPECT_NEAR(combination.weights(0, 0)(2), first(2), 0.02);
  EXPECT_NEAR(combination.weights(0, 1)(2), second(2), 0.02);
  EXPECT_NEAR(combination.weights(0, 2)(0), 0.2, 0.05);
  EXPECT_LT(std::abs(combination.weights(0, 2)(2)), 0.71) << "between the two";
}

TEST(ContinuationCombination, GoesBackToItsFirstWeightsWithTime) {
  ContinuationCombination combination(2);
  std::mt19937_64 random(5);
  for (int i = 0; i < 5000; ++i) {
    const Terms terms = drawn_terms(random);
    combination.learn(0, 0, terms, 0, 0.05F);
  }
  combination.solve();
  EXPECT_LT(std::abs(combination.weights(0, 0)(0)), 0.05) << "nothing ever moved on";
  combination.forget(1800);
  combination.solve();
  EXPECT_NEAR(combination.weights(0, 0)(0), 1, 0.01);
  EXPECT_NEAR(combination.weights(0, 0)(2), 0, 0.01);
}

TEST(ContinuationCombination, StaysFiniteWhateverTheTerms) {
  ContinuationCombination combination(2);
  const float infinite = std::numeric_limits<float>::infinity();
  combination.learn(0, 0, {infinite, 1, 1, 1}, 1, 0.01F);
  combination.learn(1, 0, {1e30F, 1e-30F, 0, 1e30F}, 1, 0.01F);
  combination.solve();
  for (std::size_t h = 0; h < 2; ++h) EXPECT_TRUE(combination.weights(h, 0).allFinite()) << h;
}

TEST(ContinuationCombination, AllocatesNothing) {
  ContinuationCombination combination(2);
  const auto before = test::allocations_of_this_thread();
  for (int i = 0; i < 10; ++i) {
    combination.learn(0, 0, {0.1F, 0.2F, 0.1F, 0}, 0.1F, 0.05F);
    combination.forget(1.0 / 60);
    combination.solve();
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
