#include "replay/study/study_score.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/study/study_picture.h"
#include "support/test_data.h"

namespace risorius {
namespace {

constexpr const char* kHeader = "page,seed,participant,pair,transition,left,right,answer,seconds,replays\n";

class StudyScore : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const auto path = folder_.path() / name;
    std::ofstream(path) << text;
    return path;
  }
  std::vector<StudyAnswer> load(const std::string& text) {
    const std::vector files{write("a.csv", text)};
    return load_study_answers(files);
  }
  /// The message of the refusal.
  std::string refused(const std::string& text) {
    try {
      load(text);
    } catch (const UserError& error) {
      return error.what();
    }
    return "was taken";
  }
  test::TemporaryFolder folder_;
};

TEST_F(StudyScore, CountsPreferencesWhateverSideTheyWereOn) {
  const auto answers = load(std::string(kHeader) +
                            "p,1,A,1,t@1,real,seed,left,2.5,0\n"
                            "p,1,A,2,t@2,seed,real,right,2,1\n"
                            "p,1,A,3,t@3,seed,real,left,3,0\n"
                            "p,1,A,4,t@4,seed,minimum_jerk,same,4,0\n"
                            "p,1,B,1,t@1,real,seed,left,1,0\n"
                            "p,1,B,4,t@4,seed,minimum_jerk,right,1,0\n");
  ASSERT_EQ(answers.size(), 6u);
  EXPECT_DOUBLE_EQ(answers[0].seconds, 2.5);
  EXPECT_EQ(answers[1].replays, 1u);
  const auto scores = score_study(answers);
  ASSERT_EQ(scores.size(), 2u);
  EXPECT_EQ(scores[0].first, "minimum_jerk");
  EXPECT_EQ(scores[0].second, "seed");
  EXPECT_EQ(scores[0].first_preferred, 1u);
  EXPECT_EQ(scores[0].second_preferred, 0u);
  EXPECT_EQ(scores[0].ties, 1u);
  EXPECT_EQ(scores[1].first, "seed");
  EXPECT_EQ(scores[1].second, "real");
  EXPECT_EQ(scores[1].first_preferred, 1u);
  EXPECT_EQ(scores[1].second_preferred, 3u);
  EXPECT_DOUBLE_EQ(scores[1].share, 0.25);
  EXPECT_EQ(scores[1].participants, 2u);
  EXPECT_DOUBLE_EQ(scores[1].p, 2 * (1 + 4) / 16.0);
  EXPECT_DOUBLE_EQ(scores[1].participants_p, 0.5) << "both prefer real";
}

TEST_F(StudyScore, OnlyTiesHaveNoShare) {
  const auto scores = score_study(load(std::string(kHeader) + "p,1,A,1,t,seed,real,same,1,0\n"));
  ASSERT_EQ(scores.size(), 1u);
  EXPECT_TRUE(std::isnan(scores[0].share));
  EXPECT_EQ(scores[0].low, 0);
  EXPECT_EQ(scores[0].high, 1);
  EXPECT_EQ(scores[0].p, 1);
  EXPECT_GT(study_picture(scores).height(), 100);
}

TEST_F(StudyScore, DamagedFilesAreRefusedWithLineFieldAndRemedy) {
  const std::string good = "p,1,A,1,t,seed,real,left,1,0\n", head = kHeader;
  const auto expect = [&](const std::string& text, const std::string& place, const std::string& problem) {
    const std::string message = refused(text);
    EXPECT_NE(message.find("a.csv" + place), std::string::npos) << message;
    EXPECT_NE(message.find(problem), std::string::npos) << message;
    EXPECT_NE(message.find(" ("), std::string::npos) << "a remedy: " << message;
  };
  expect("page,seed\n1,2\n", ", line 1", "no column participant");
  expect("page,page,seed,participant,pair,transition,left,right,answer,seconds,replays\n", ", line 1", "stands twice");
  expect(head, "", "there is no answer");
  expect(head + good + "p,1,A,2,t,seed,real,up,1,0\n", ", line 3, column answer", "'up' is no answer");
  expect(head + "p,1,A,2,t,seed,real,left,-1,0\n", ", line 2, column seconds", "'-1' is no time");
  expect(head + "p,1,A,2,t,seed,real,left,nan,0\n", ", line 2, column seconds", "'nan' is no time");
  expect(head + "p,1,A,2,t,seed,real,left,1,often\n", ", line 2, column replays", "'often' is no whole number");
  expect(head + "p,1,A,0,t,seed,real,left,1,0\n", ", line 2, column pair", "'0' is no pair");
  expect(head + "p,x,A,1,t,seed,real,left,1,0\n", ", line 2, column seed", "'x' is no whole number");
  expect(head + "p,1,A,1,t,real,real,left,1,0\n", ", line 2, column right", "on both sides");
  expect(head + "p,1,,1,t,seed,real,left,1,0\n", ", line 2, column participant", "is empty");
  expect(head + "p,1,A,1,t,seed,real\n", ", line 2", "7 cells");
  expect(head + good + good, ", line 3", "was answered by A already");
  expect(head + good + "p,1,B,1,t,minimum_jerk,real,left,1,0\n", ", line 3", "pair 1 of page p");
}

TEST_F(StudyScore, OneParticipantCountsOnceOverSeveralFiles) {
  const std::vector files{write("a.csv", std::string(kHeader) + "p,1,A,1,t,seed,real,left,1,0\n"),
                          write("b.csv", std::string(kHeader) + "p,1,A,1,t,seed,real,left,1,0\n")};
  try {
    load_study_answers(files);
    FAIL() << "the same answers twice";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("a.csv, line 2"), std::string::npos) << error.what();
  }
  EXPECT_THROW(load_study_answers(std::vector<std::filesystem::path>{folder_.path() / "none.csv"}), UserError);
}

TEST(StudyStatistics, IntervalsAreWilsons) {
  // Checked by hand for 8 of 10: (0.8 + 1.92073 / 10 -+ 1.95996 sqrt(0.016 + 0.0096036)) / 1.384146.
  const Interval interval = wilson_interval(8, 10);
  EXPECT_NEAR(interval.low, 0.4901625, 1e-6);
  EXPECT_NEAR(interval.high, 0.9433178, 1e-6);
  EXPECT_DOUBLE_EQ(wilson_interval(0, 10).low, 0);
  EXPECT_NEAR(wilson_interval(0, 10).high, 0.2775328, 1e-6);
  EXPECT_NEAR(wilson_interval(10, 10).low, 1 - 0.2775328, 1e-6);
  EXPECT_EQ(wilson_interval(0, 0).high, 1);
}

TEST(StudyStatistics, TheSignTestIsExact) {
  EXPECT_NEAR(sign_test_p(0, 5), 2.0 / 32, 1e-12);
  EXPECT_NEAR(sign_test_p(2, 8), 2 * (1 + 10 + 45) / 1024.0, 1e-12);
  EXPECT_DOUBLE_EQ(sign_test_p(8, 2), sign_test_p(2, 8));
  EXPECT_EQ(sign_test_p(5, 5), 1);
  EXPECT_EQ(sign_test_p(0, 0), 1);
  EXPECT_GT(sign_test_p(450, 550), 0.001);
  EXPECT_LT(sign_test_p(450, 550), 0.003);
}

TEST(StudyPicture, BarsEndAtTheShare) {
  ComparisonScore score;
  score.first = "seed";
  score.second = "real";
  score.first_preferred = 20;
  score.second_preferred = 80;
  score.share = 0.2;
  score.low = 0.13;
  score.high = 0.29;
  const std::vector scores{score, score};
  const Canvas canvas = study_picture(scores);
  // Along the upper edge of the first bar: one colour up to a fifth of the way, another from there on.
  const int left = 210, right = canvas.width() - 210, y = 74;
  const auto at = [&](double share) { return canvas.pixel(left + static_cast<int>(share * (right - left)), y); };
  EXPECT_EQ(at(0.05), at(0.19));
  EXPECT_NE(at(0.19), at(0.22));
  EXPECT_EQ(at(0.22), at(0.95));
  EXPECT_THROW(study_picture({}), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
