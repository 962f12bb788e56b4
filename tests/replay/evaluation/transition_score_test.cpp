#include "replay/evaluation/transition_score.h"

#include <gtest/gtest.h>
#include <initializer_list>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kRate_hz = 120;
constexpr double kRounding = 1e-5;  // of float intensities, times the rate where they are differentiated

AuMatrix column(std::initializer_list<double> values) {
  AuMatrix series(static_cast<Eigen::Index>(values.size()), 1);
  Eigen::Index row = 0;
  for (const double value : values) series(row++, 0) = static_cast<float>(value);
  return series;
}

TransitionScore score(const AuMatrix& past, const AuMatrix& truth, const AuMatrix& made) {
  return score_transition(past, truth, made, kRate_hz);
}

TEST(TransitionScore, ErrorsAreMeansOverFramesAndAus) {
  AuMatrix truth(2, 2), made(2, 2);
  truth << 0.1F, 0.5F, 0.2F, 0.5F;
  made << 0.2F, 0.5F, 0.2F, 0.8F;
  const TransitionScore s = score(AuMatrix::Zero(1, 2), truth, made);
  EXPECT_NEAR(s.mean_squared_error, (0.01 + 0.09) / 4, kRounding);
  EXPECT_NEAR(s.mean_absolute_error, (0.1 + 0.3) / 4, kRounding);
  ASSERT_EQ(s.squared_error_by_au.size(), 2u);
  EXPECT_NEAR(s.squared_error_by_au[0], 0.005, kRounding);
  EXPECT_NEAR(s.squared_error_by_au[1], 0.045, kRounding);
  EXPECT_NEAR(s.conspicuousness.summed_error, 0.005 + 0.045, kRounding) << "summed over frames";
  EXPECT_NEAR(s.end_error_percent, 25, 1e-3) << "0.3 of 1.2";
}

TEST(TransitionScore, ASeamIsWhatThePastDidNotAnnounce) {
  const AuMatrix line = column({0.20, 0.21, 0.22, 0.23});
  const std::vector<bool> counted{true};
  const SeamJump none = seam_jump(line, column({0.24}), kRate_hz, counted);
  EXPECT_NEAR(none.value, 0, kRounding);
  EXPECT_NEAR(none.velocity_per_s, 0, kRate_hz * kRounding);
  // 0.05 beyond the line: by the formulas 0.05, 0.05 x 120 and 0.05 x 120^2.
  const SeamJump jump = seam_jump(line, column({0.29}), kRate_hz, counted);
  EXPECT_NEAR(jump.value, 0.05, kRounding);
  EXPECT_NEAR(jump.velocity_per_s, 6, kRate_hz * kRounding);
  EXPECT_NEAR(jump.acceleration_per_s2, 720, kRate_hz * kRate_hz * kRounding);
  // A parabola of second difference 0.01 that goes on: its acceleration is the past's own.
  const SeamJump parabola = seam_jump(column({0, 0.01, 0.03, 0.06}), column({0.10}), kRate_hz, counted);
  EXPECT_NEAR(parabola.value, 0.01, kRounding);
  EXPECT_NEAR(parabola.velocity_per_s, 0, kRate_hz * kRounding);
  EXPECT_NEAR(parabola.acceleration_per_s2, 0, kRate_hz * kRate_hz * kRounding);
}

TEST(TransitionScore, APastOfOneFrameWasStill) {
  const SeamJump jump = seam_jump(column({0.5}), column({0.6}), kRate_hz, {true});
  EXPECT_NEAR(jump.value, 0.1, kRounding);
  EXPECT_NEAR(jump.velocity_per_s, 12, kRate_hz * kRounding);
}

TEST(TransitionScore, OnlyAusThatMoveCountForTheSeam) {
  AuMatrix past(1, 2), truth(2, 2), made(2, 2);
  past << 0, 0.5F;
  truth << 0.1F, 0.5F, 0.4F, 0.52F;
  made << 0.2F, 0.9F, 0.4F, 0.52F;
  const TransitionScore s = score(past, truth, made);
  EXPECT_EQ(s.moving_aus, 1);
  EXPECT_NEAR(s.seam.value, 0.2, kRounding);
  EXPECT_NEAR(s.truth_seam.value, 0.1, kRounding);
  // Seed 003's percentages are over all AUs: 0.2 and 0.4 of 1.2.
  EXPECT_NEAR(s.mean_jump_percent, (16.6667 + 33.3333) / 2, 1e-3);
  EXPECT_NEAR(s.largest_jump_percent, 33.3333, 1e-3);
}

TEST(TransitionScore, CountsWhatLeavesTheBounds) {
  const TransitionScore s = score(column({0}), column({0.1, 0.2, 0.3, 0.4}), column({-0.01, 1.3, 1.2, 0.4}));
  EXPECT_EQ(s.values_out_of_bounds, 2);
}

TEST(TransitionScore, TheTruthItselfIsInconspicuousAndWithoutErrors) {
  // A blink on the way, fast and against the way: but the truth's own.
  const AuMatrix truth = column({0.3, 0.7, 1.0, 0.6, 0.2, 0.1});
  const TransitionScore s = score(column({0}), truth, truth);
  EXPECT_EQ(s.mean_squared_error, 0);
  EXPECT_EQ(s.end_error_percent, 0);
  EXPECT_EQ(s.end_step_percent, 0);
  EXPECT_NEAR(s.reactivation_percent, 75, 1e-3);
  EXPECT_EQ(s.conspicuousness.reactivation_percent, 0);
  EXPECT_FALSE(s.conspicuousness.is_conspicuous());
}

TEST(TransitionScore, HoldJumpsAtItsEnd) {
  const TransitionScore s = score(column({0}), column({0.2, 0.4, 0.6}), column({0, 0, 0.6}));
  EXPECT_NEAR(s.end_step_percent, 100 * (0.6 - 0.2) / 1.2, 1e-3);
}

TEST(TransitionScore, RefusesSizesThatDoNotFit) {
  EXPECT_THROW(score(AuMatrix(0, 1), column({1}), column({1})), std::invalid_argument);
  EXPECT_THROW(score(column({1}), column({1, 2}), column({1})), std::invalid_argument);
  EXPECT_THROW(score(AuMatrix::Zero(1, 2), column({1}), column({1})), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
