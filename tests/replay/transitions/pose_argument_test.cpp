#include "replay/transitions/pose_argument.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/test_data.h"

namespace risorius {
namespace {

const std::vector<std::string> kDefaults{"AU6L", "AU6R", "AU12L", "AU12R"};

class Ends : public ::testing::Test {
 protected:
  std::string write(const char* name, const char* text) {
    const auto path = folder_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }
  test::TemporaryFolder folder_;
};

TEST_F(Ends, TwoExpressionsAreTwoFramesOfTheDefaultAus) {
  const TransitionEnds ends = transition_ends("neutral", "happy", kDefaults);
  EXPECT_EQ(ends.names, kDefaults);
  ASSERT_EQ(ends.past.rows(), 1);
  EXPECT_TRUE(ends.past.isZero());
  EXPECT_FLOAT_EQ(ends.target[2], 0.9F);
}

TEST_F(Ends, ASeriesStartsAtItsLastFrameWithItsPastAndEndsAtItsFirst) {
  const std::string series = write("a.csv", "Frame,AU12L,AU1\n0,0.1,0\n1,0.2,0\n2,0.4,0.5\n");
  const TransitionEnds from = transition_ends(series, "neutral", kDefaults);
  EXPECT_EQ(from.names, (std::vector<std::string>{"AU12L", "AU1"}));
  ASSERT_EQ(from.past.rows(), 3);
  EXPECT_FLOAT_EQ(from.past(2, 0), 0.4F);
  EXPECT_FLOAT_EQ(from.past(2, 1), 0.5F);
  EXPECT_EQ(transition_ends(series, "neutral", kDefaults, {.most_past_frames = 2}).past.rows(), 2);
  const TransitionEnds to = transition_ends("neutral", series, kDefaults);
  EXPECT_EQ(to.names, from.names);
  EXPECT_FLOAT_EQ(to.target[0], 0.1F);
}

TEST_F(Ends, ThePastComesAtTheCoursesRateWhateverTheFiles) {
  // 0.1 in 1/30 s: 3 per s, also in frames of 1/120 s.
  const std::string series = write("a.csv", "Frame,AU12L\n0,0.1\n1,0.2\n2,0.3\n");
  const TransitionEnds ends = transition_ends(series, "neutral", kDefaults, {.rate_hz = 120, .from_rate_hz = 30});
  ASSERT_EQ(ends.past.rows(), 9);
  for (Eigen::Index row = 0; row < 9; ++row)
    EXPECT_NEAR(ends.past(row, 0), 0.1 + 0.025 * static_cast<double>(row), 1e-6);
  EXPECT_TRUE(ends.notes.empty());
  const TransitionEnds fast = transition_ends(series, "neutral", kDefaults, {.rate_hz = 15, .from_rate_hz = 30});
  ASSERT_EQ(fast.past.rows(), 2);
  EXPECT_NEAR(fast.past(0, 0), 0.1, 1e-6);
  const TransitionEnds unknown = transition_ends(series, "neutral", kDefaults);
  ASSERT_EQ(unknown.notes.size(), 1u);
  EXPECT_NE(unknown.notes[0].find("states no rate: 120 Hz assumed"), std::string::npos) << unknown.notes[0];
}

TEST_F(Ends, AFrameIsChosenByItsNumber) {
  const std::string series = write("a.csv", "Frame,AU12L\n10,0.1\n20,0.2\n30,0.4\n");
  EXPECT_FLOAT_EQ(transition_ends("neutral", series + ":20", kDefaults).target[0], 0.2F);
  const TransitionEnds from = transition_ends(series + ":20", "neutral", kDefaults);
  ASSERT_EQ(from.past.rows(), 2);
  EXPECT_FLOAT_EQ(from.past(1, 0), 0.2F);
  EXPECT_THROW(transition_ends(series + ":15", "neutral", kDefaults), UserError);
  EXPECT_THROW(transition_ends(series + ":x", "neutral", kDefaults), UserError);
}

TEST_F(Ends, ColumnsOfTheOtherSeriesAreFoundByNameAndWhatLacksIsSaid) {
  const std::string from = write("from.csv", "Frame,AU1,AU12L,AU12R\n0,0.1,0.2,0.3\n");
  const std::string to = write("to.csv", "Frame,AU12R,AU12L\n0,0.7,0.6\n");
  const TransitionEnds ends = transition_ends(from, to, kDefaults);
  EXPECT_FLOAT_EQ(ends.target[0], 0);
  EXPECT_FLOAT_EQ(ends.target[1], 0.6F);
  EXPECT_FLOAT_EQ(ends.target[2], 0.7F);
  ASSERT_EQ(ends.notes.size(), 1u);
  EXPECT_NE(ends.notes[0].find("has no AU1"), std::string::npos) << ends.notes[0];
  const std::string holes = write("holes.csv", "Frame,AU1,AU12L,AU12R\n0,0.1,,0.3\n");
  const TransitionEnds unobserved = transition_ends(holes, "neutral", kDefaults);
  EXPECT_FLOAT_EQ(unobserved.past(0, 1), 0);
  ASSERT_EQ(unobserved.notes.size(), 1u);
  EXPECT_NE(unobserved.notes[0].find("does not observe AU12L"), std::string::npos) << unobserved.notes[0];
}

TEST_F(Ends, WhatIsAboveTheMostIsCutAndSaid) {
  const std::string from = write("from.csv", "Frame,AU12L,AU12R\n0,1.5,1.2\n");
  const TransitionEnds ends = transition_ends(from, "neutral", kDefaults);
  EXPECT_FLOAT_EQ(ends.past(0, 0), 1.2F);
  ASSERT_EQ(ends.notes.size(), 1u);
  EXPECT_NE(ends.notes[0].find("above 1.2 there, which is the most: cut: AU12L 1.5"), std::string::npos)
      << ends.notes[0];
}

TEST_F(Ends, ShapesAreReadAsAus) {
  const std::string shapes = write("shapes.csv", "Frame,mouthSmileLeft,mouthSmileRight\n0,0.6,0.1\n");
  const TransitionEnds ends = transition_ends("neutral", shapes, kDefaults);
  const auto left = std::ranges::find(ends.names, "AU12L");
  ASSERT_NE(left, ends.names.end());
  EXPECT_GT(ends.target[left - ends.names.begin()], 0.3F);
  const std::string aus = write("aus.csv", "Frame,AU12L,AU12R\n0,0.6,0.1\n");
  EXPECT_GT(transition_ends(aus, shapes, kDefaults).target[0], 0.3F) << "onto the AUs of the start";
}

TEST_F(Ends, WhatTheTargetWantsAndTheStartDoesNotHaveIsSaid) {
  const std::string from = write("from.csv", "Frame,AU12L\n0,0.1\n");
  const std::string to = write("to.csv", "Frame,AU12L,AU6L,AU4L\n0,0.6,0.7,0\n");
  const TransitionEnds ends = transition_ends(from, to, kDefaults);
  ASSERT_EQ(ends.notes.size(), 1u);
  EXPECT_NE(ends.notes[0].find("to.csv wants AU6L, for which there is no column"), std::string::npos) << ends.notes[0];
}

TEST_F(Ends, ATargetOfOtherChannelsIsRefused) {
  const std::string from = write("from.csv", "Frame,AU12L,AU12R\n0,0.1,0.2\n");
  const std::string to = write("to.csv", "Frame,smile\n0,0.7\n");
  try {
    transition_ends(from, to, kDefaults);
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("has none of the AUs of"), std::string::npos) << error.what();
  }
}

TEST_F(Ends, WhatIsNeitherAFileNorAnExpressionIsRefused) {
  EXPECT_THROW(transition_ends("furious", "happy", kDefaults), UserError);
  EXPECT_THROW(transition_ends("happy", (folder_.path() / "nowhere.csv").string(), kDefaults), UserError);
}

}  // namespace
}  // namespace risorius
