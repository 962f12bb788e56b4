#include "replay/evaluation/conspicuousness.h"

#include <gtest/gtest.h>
#include <initializer_list>
#include <stdexcept>

namespace risorius {
namespace {

AuMatrix column(std::initializer_list<double> values) {
  AuMatrix series(static_cast<Eigen::Index>(values.size()), 1);
  Eigen::Index row = 0;
  for (const double value : values) series(row++, 0) = static_cast<float>(value);
  return series;
}

/// At all thresholds, above none.
constexpr Conspicuousness kAtTheThresholds{.summed_error = 1,
                                           .largest_jump_percent = 40,
                                           .third_jump_percent = 20,
                                           .reactivation_percent = 25,
                                           .end_percent = 25};

template <class Change>
Conspicuousness with(Change change) {
  Conspicuousness c = kAtTheThresholds;
  change(c);
  return c;
}

TEST(Reactivation, IsTheWayAgainstTheTransition) {
  const auto percent = [](double start, std::initializer_list<double> course) {
    return reactivation_percent(start, column(course), 0);
  };
  EXPECT_NEAR(percent(1, {0.8, 0.5, 0.2, 0}), 0, 1e-4) << "straight down";
  EXPECT_NEAR(percent(1, {0.5, 0.8, 0.2, 0}), 25, 1e-4) << "up again by 0.3";
  EXPECT_NEAR(percent(0.2, {0.6, 0.3, 0.9}), 25, 1e-4) << "down again on the way up";
  EXPECT_NEAR(percent(0, {0.6, 0}), 50, 1e-4) << "there and back";
  EXPECT_NEAR(percent(1, {1.12, 0}), 10, 1e-4) << "first the wrong way";
  EXPECT_EQ(percent(0.5, {}), 0);
}

TEST(Conspicuousness, IsEachOfItsCriteriaAlone) {
  EXPECT_FALSE(kAtTheThresholds.is_conspicuous());
  EXPECT_TRUE(with([](auto& c) { c.summed_error = 1.01; }).is_conspicuous());
  EXPECT_TRUE(with([](auto& c) { c.largest_jump_percent = 40.1; }).is_conspicuous());
  EXPECT_TRUE(with([](auto& c) { c.third_jump_percent = 20.1; }).is_conspicuous());
  EXPECT_TRUE(with([](auto& c) { c.reactivation_percent = 25.1; }).is_conspicuous());
  EXPECT_TRUE(with([](auto& c) { c.end_percent = 25.1; }).is_conspicuous());
}

TEST(Conspicuousness, IsNarrowByOneCriterionAndAQuarterAtMost) {
  EXPECT_EQ(kAtTheThresholds.rating(), TransitionRating::kInconspicuous);
  EXPECT_EQ(with([](auto& c) { c.summed_error = 1.25; }).rating(), TransitionRating::kNarrow);
  EXPECT_EQ(with([](auto& c) { c.summed_error = 1.26; }).rating(), TransitionRating::kConspicuous);
  EXPECT_EQ(with([](auto& c) { c.end_percent = 31; }).rating(), TransitionRating::kNarrow);
  EXPECT_EQ(with([](auto& c) { c.end_percent = 32; }).rating(), TransitionRating::kConspicuous);
  EXPECT_EQ(with([](auto& c) { c.end_percent = c.reactivation_percent = 26; }).rating(), TransitionRating::kConspicuous)
      << "two criteria";
  EXPECT_EQ(with([](auto& c) {
              c.largest_jump_percent = 45;
              c.third_jump_percent = 22;
            }).rating(),
            TransitionRating::kNarrow)
      << "one large jump and three smaller ones are one criterion, jumps";
  EXPECT_EQ(with([](auto& c) {
              c.largest_jump_percent = 45;
              c.third_jump_percent = 26;
            }).rating(),
            TransitionRating::kConspicuous);
}

TEST(Conspicuousness, HasTheSymbolsOfSeed003) {
  EXPECT_EQ(symbol_of(TransitionRating::kInconspicuous), '+');
  EXPECT_EQ(symbol_of(TransitionRating::kNarrow), 'o');
  EXPECT_EQ(symbol_of(TransitionRating::kConspicuous), '-');
}

TEST(Conspicuousness, SeesAJumpAnywhereInTheCourse) {
  AuMatrix truth(10, 3), made(10, 3);
  for (Eigen::Index row = 0; row < 10; ++row) {
    truth.row(row).setConstant(0.1F * static_cast<float>(row + 1));
    made.row(row).setConstant(row < 5 ? 0.4F : 0.7F);  // 33 % at the start, 25 % in the middle
  }
  made.row(9) = truth.row(9);
  const Conspicuousness c = conspicuousness_of(AuMatrix::Zero(1, 3), truth, made);
  EXPECT_NEAR(c.largest_jump_percent, 100 * 0.4 / 1.2, 1e-3);
  EXPECT_NEAR(c.third_jump_percent, 100 * 0.4 / 1.2, 1e-3);
  EXPECT_TRUE(c.is_conspicuous());
}

TEST(Conspicuousness, TheThirdJumpIsThatOfTheThirdAu) {
  AuMatrix truth = AuMatrix::Zero(3, 4), made = AuMatrix::Zero(3, 4);
  made.row(1) << 0.12F, 0.48F, 0.24F, 0.36F;  // 10, 40, 20 and 30 %
  const Conspicuousness c = conspicuousness_of(AuMatrix::Zero(1, 4), truth, made);
  EXPECT_NEAR(c.largest_jump_percent, 40, 1e-4);
  EXPECT_NEAR(c.third_jump_percent, 20, 1e-4);
  const Conspicuousness two = conspicuousness_of(AuMatrix::Zero(1, 2), truth.leftCols(2), made.leftCols(2));
  EXPECT_EQ(two.third_jump_percent, 0) << "two AUs have no third jump";
}

TEST(Conspicuousness, DoesNotBlameTheModelForWhatTheTruthDoes) {
  // A blink on the way, against the way: but the truth's own.
  const AuMatrix truth = column({0.3, 0.7, 1.0, 0.6, 0.2, 0.1});
  const Conspicuousness c = conspicuousness_of(column({0}), truth, truth);
  EXPECT_EQ(c.summed_error, 0);
  EXPECT_EQ(c.reactivation_percent, 0);
  EXPECT_EQ(c.end_percent, 0);
  EXPECT_EQ(c.rating(), TransitionRating::kInconspicuous);
}

TEST(Conspicuousness, MeasuresTheEndsAgainstTheTruth) {
  const AuMatrix truth = column({0.12, 0.3, 0.6});
  const Conspicuousness early = conspicuousness_of(column({0}), truth, column({0.36, 0.5, 0.6}));
  EXPECT_NEAR(early.end_percent, 20, 1e-4) << "30 % where the truth itself goes 10 %";
  const Conspicuousness late = conspicuousness_of(column({0}), truth, column({0.12, 0.2, 0.24}));
  EXPECT_NEAR(late.end_percent, 30, 1e-4) << "0.36 short of the target";
}

TEST(Conspicuousness, RefusesSizesThatDoNotFit) {
  EXPECT_THROW(conspicuousness_of(AuMatrix(0, 1), column({1}), column({1})), std::invalid_argument);
  EXPECT_THROW(conspicuousness_of(column({1}), AuMatrix(0, 1), AuMatrix(0, 1)), std::invalid_argument);
  EXPECT_THROW(conspicuousness_of(column({1}), column({1, 2}), column({1})), std::invalid_argument);
  EXPECT_THROW(conspicuousness_of(AuMatrix::Zero(1, 2), column({1}), column({1})), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
