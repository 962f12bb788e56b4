#include "replay/evaluation/expression_tables.h"

#include <gtest/gtest.h>
#include <stdexcept>

#include "replay/evaluation/expression_table_csv.h"
#include "replay/evaluation/expression_table_pictures.h"

namespace risorius {
namespace {

constexpr double kRounding = 1e-4;  // of float intensities, in %

/// Two AUs from 0 to (0.6, 0) in three frames.
Transition performed(const std::string& from, const std::string& to, std::size_t variant) {
  Transition one;
  one.from = from;
  one.to = to;
  one.variant = variant;
  one.past = AuMatrix::Zero(4, 2);
  one.course = AuMatrix::Zero(3, 2);
  one.course.col(0) << 0.06F, 0.3F, 0.6F;
  return one;
}

/// The course itself with `first` in its first frame.
ScoredTransition made(const Transition& one, float first_au, float second_au, bool is_seen) {
  AuMatrix course = one.course;
  course.row(0) << first_au, second_au;
  return score_for_tables(one, course, is_seen);
}

const Transition kHappySad = performed("happy", "sad", 0), kHappySad5 = performed("happy", "sad", 4),
                 kSadHappy = performed("sad", "happy", 0), kHappyNeutral = performed("happy", "neutral", 0);

/// Two transitions of one pair, one of another, not in order.
ScoredModel model_of(const std::string& name, float first_au) {
  return {name,
          {made(kSadHappy, first_au, 0, true), made(kHappySad5, first_au, 0, false),
           made(kHappySad, first_au, 0.12F, true)}};
}

TEST(ExpressionTables, ScoreATransitionByItsCourses) {
  const ScoredTransition one = made(kHappySad5, 0.36F, 0.12F, false);
  EXPECT_EQ(one.from, "happy");
  EXPECT_EQ(one.to, "sad");
  EXPECT_EQ(one.variant, 4u);
  EXPECT_FALSE(one.is_seen);
  ASSERT_EQ(one.jumps_percent.size(), 2u);
  EXPECT_NEAR(one.jumps_percent[0], 30, kRounding) << "0.36 of 1.2";
  EXPECT_NEAR(one.jumps_percent[1], 10, kRounding);
  EXPECT_NEAR(one.conspicuousness.summed_error, (0.3 * 0.3 + 0.12 * 0.12) / 2, 1e-6);
  EXPECT_THROW(score_for_tables(kHappySad, AuMatrix::Zero(2, 2), true), std::invalid_argument);
}

TEST(ExpressionTables, ErrorsStandInTheOrderOfSeed003ByModel) {
  const std::vector<ScoredModel> models{model_of("exact", 0.06F), model_of("early", 0.36F)};
  const std::vector<ErrorRow> rows = error_rows(models);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].from + rows[0].to, "happysad");
  EXPECT_EQ(rows[0].variant, 0u);
  EXPECT_EQ(rows[1].variant, 4u);
  EXPECT_FALSE(rows[1].is_seen);
  EXPECT_EQ(rows[2].from, "sad");
  ASSERT_EQ(rows[1].errors.size(), 2u);
  EXPECT_EQ(rows[1].errors[0], 0);
  EXPECT_NEAR(rows[1].errors[1], 0.3 * 0.3 / 2, 1e-6);
  EXPECT_NEAR(rows[0].errors[0], 0.12 * 0.12 / 2, 1e-6);
  EXPECT_TRUE(error_rows({}).empty());
}

TEST(ExpressionTables, RefuseModelsThatMadeOtherTransitions) {
  std::vector<ScoredModel> models{model_of("a", 0), model_of("b", 0)};
  models[1].transitions.pop_back();
  EXPECT_THROW(error_rows(models), std::invalid_argument);
  models[1].transitions.push_back(made(kHappyNeutral, 0, 0, true));
  EXPECT_THROW(error_rows(models), std::invalid_argument) << "as many, but another pair";
  models[1] = model_of("b", 0);
  models[1].transitions[0] = models[1].transitions[1];
  EXPECT_THROW(error_rows(models), std::invalid_argument) << "one twice";
  EXPECT_THROW(jump_rows(models[1]), std::invalid_argument);
}

TEST(ExpressionTables, JumpsHaveTheirLeastMeanAndMost) {
  const std::vector<JumpRow> rows = jump_rows(model_of("early", 0.36F));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_NEAR(rows[0].percent[0], 30, kRounding);
  EXPECT_NEAR(rows[0].least, 10, kRounding);
  EXPECT_NEAR(rows[0].mean, 20, kRounding);
  EXPECT_NEAR(rows[0].most, 30, kRounding);
  EXPECT_NEAR(rows[2].least, 0, kRounding);
  EXPECT_NEAR(rows[2].mean, 15, kRounding);
  ScoredModel none{"none", {ScoredTransition{}}};
  EXPECT_THROW(jump_rows(none), std::invalid_argument) << "a transition without AUs";
}

TEST(ExpressionTables, ReproduceTheJumpTableOfSeed003) {
  // Its Table 6.3: frames 19 and 20; the last two lines of it are |x1 - x0| in % and what is left of 100 %.
  Transition one;
  one.past = AuMatrix(1, 5);
  one.past << 0.05F, 1.16F, 0.38F, 0.41F, 0.00F;  // AU2L, AU4L, AU9, AU13L, AU18
  AuMatrix first(1, 5);
  first << -0.04F, 1.05F, -0.36F, -0.10F, 0.38F;
  one.course = first;
  const ScoredTransition made = score_for_tables(one, first, true);
  const std::vector<double> printed{6.78, 9.14, 61.18, 42.33, 31.74};
  // Both frames are printed to 0.01, which is 0.83 % of the range.
  for (std::size_t au = 0; au < printed.size(); ++au) EXPECT_NEAR(made.jumps_percent[au], printed[au], 0.84) << au;
  EXPECT_EQ(made.conspicuousness.rating(), TransitionRating::kConspicuous) << "as seed 003 judged it";
}

TEST(ExpressionTables, RatingsStandFromExpressionToExpressionBySeenAndUnseen) {
  ScoredModel model = model_of("m", 0.06F);
  model.transitions[2].conspicuousness = {.summed_error = 1.2};
  model.transitions.push_back(made(performed("happy", "sad", 1), 0.9F, 0, true));
  const RatingMatrix seen = rating_matrix(model, true), unseen = rating_matrix(model, false);
  EXPECT_EQ(seen.expressions, (std::vector<std::string>{"happy", "sad"}));
  ASSERT_EQ(seen.cells[0][1].ratings.size(), 2u);
  EXPECT_EQ(seen.cells[0][1].ratings[0], TransitionRating::kNarrow);
  EXPECT_EQ(seen.cells[0][1].ratings[1], TransitionRating::kConspicuous);
  EXPECT_EQ(seen.cells[0][1].worst(), TransitionRating::kConspicuous);
  EXPECT_EQ(seen.cells[1][0].worst(), TransitionRating::kInconspicuous);
  EXPECT_EQ(seen.cells[1][0].ratings.size(), 1u);
  EXPECT_TRUE(seen.cells[0][0].ratings.empty());
  EXPECT_EQ(unseen.cells[0][1].ratings.size(), 1u);
  EXPECT_TRUE(unseen.cells[1][0].ratings.empty());
}

TEST(ExpressionTables, SummariesAreMeansOverTransitionsAndAus) {
  ScoredModel model = model_of("m", 0.36F);
  model.transitions.push_back(made(performed("sad", "neutral", 0), 0.96F, 0, true));  // no pair of Table 4.2
  const TableSummary seen = table_summary(model, true), known = table_summary(model, true, TablePairs::kSeed003);
  EXPECT_EQ(seen.count, 3u);
  EXPECT_NEAR(seen.mean_jump_percent, (30 + 30 + 10 + 80) / 6.0, kRounding);
  EXPECT_NEAR(seen.largest_jump_percent, 80, kRounding);
  EXPECT_NEAR(seen.mean_error, (0.045 + 0.045 + 0.0072 + 0.405) / 3, 1e-5);
  EXPECT_EQ(known.count, 2u);
  EXPECT_NEAR(known.mean_jump_percent, (30 + 30 + 10) / 4.0, kRounding);
  EXPECT_EQ(seen.inconspicuous + seen.narrow + seen.conspicuous, 3u);
  EXPECT_EQ(seen.conspicuous, 1u);
  EXPECT_EQ(table_summary(model, false).count, 1u);
  EXPECT_EQ(table_summary({"none", {}}, true).mean_error, 0);
}

TEST(ExpressionTableCsv, HasARowPerTransitionAndMarksWhatSeed003Recorded) {
  const std::vector<ScoredModel> models{model_of("exact", 0.06F), model_of("early", 0.36F)};
  EXPECT_EQ(error_csv(models),
            "from,to,variant,seen,seed003,exact,early\n"
            "happy,sad,1,1,1,0.0072,0.0522\n"
            "happy,sad,5,0,1,0.0000,0.0450\n"
            "sad,happy,1,1,1,0.0000,0.0450\n");
  const std::vector<ScoredModel> early{models[1]};
  EXPECT_EQ(jump_csv(early, {"AU1", "AU2"}),
            "model,from,to,variant,seen,seed003,AU1,AU2,least,mean,most\n"
            "early,happy,sad,1,1,1,30.000,10.000,10.000,20.000,30.000\n"
            "early,happy,sad,5,0,1,30.000,0.000,0.000,15.000,30.000\n"
            "early,sad,happy,1,1,1,30.000,0.000,0.000,15.000,30.000\n");
  EXPECT_THROW(jump_csv(early, {"AU1"}), std::invalid_argument);
}

TEST(ExpressionTableCsv, RatingsCarryWhatTheyFollowFrom) {
  const std::vector<ScoredModel> models{{"m", {made(performed("sad", "neutral", 1), 0.36F, 0, false)}}};
  // 30 % at once, then 0.36 -> 0.3 -> 0.6: 5 % back; 25 % more at the start than the truth's 5 %: on the threshold.
  const std::string text = rating_csv(models);
  EXPECT_EQ(text.substr(text.find('\n') + 1, 41), "m,sad,neutral,2,0,0,0.0450,30.000,0.000,5") << text;
  EXPECT_NE(summary_csv(models).find("m,0,all,1,0.0450,15.000,30.000,"), std::string::npos);
  EXPECT_NE(summary_csv(models).find("m,0,seed003,0,0.0000,0.000,0.000,0,0,0\n"), std::string::npos);
}

TEST(ExpressionTablePictures, AreDrawnForAnyModels) {
  const std::vector<ScoredModel> models{model_of("exact", 0.06F), model_of("early", 0.36F)};
  const Canvas one = error_picture(std::span(models).first(1)), two = error_picture(models);
  EXPECT_EQ(one.height(), two.height());
  EXPECT_GT(summary_picture(models).height(), summary_picture(std::span(models).first(1)).height());
  EXPECT_GT(jump_picture(models[0], {"AU1", "AU2"}).width(), 100);
  EXPECT_GT(rating_picture(models[0]).width(), 300);
  EXPECT_THROW(jump_picture(models[0], {"AU1"}), std::invalid_argument);
  EXPECT_GT(rating_picture({"nothing", {}}).width(), 100);
}

}  // namespace
}  // namespace risorius
