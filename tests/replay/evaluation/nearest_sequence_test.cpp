#include "replay/evaluation/nearest_sequence.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

namespace risorius {
namespace {

AuMatrix ramp(Eigen::Index rows, float from, float to) {
  AuMatrix series(rows, 2);
  for (Eigen::Index row = 0; row < rows; ++row)
    series.row(row).setConstant(from + (to - from) * static_cast<float>(row) / static_cast<float>(rows - 1));
  return series;
}

TEST(SequenceIndex, FindsACopyAtAnyLength) {
  SequenceIndex index(2);
  index.add(ramp(60, 0, 1));
  index.add(ramp(60, 1, 0));
  EXPECT_NEAR(index.nearest_rms(ramp(60, 0, 1)), 0, 1e-6);
  EXPECT_NEAR(index.nearest_rms(ramp(402, 1, 0)), 0, 1e-6);
}

TEST(SequenceIndex, TellsTheRootMeanSquareToTheNearest) {
  SequenceIndex index(2);
  index.add(ramp(60, 0, 1));
  index.add(ramp(60, 0.5F, 1.5F));
  EXPECT_NEAR(index.nearest_rms(ramp(50, 0.1F, 1.1F)), 0.1, 1e-6);
  EXPECT_EQ(index.size(), 2u);
}

TEST(SequenceIndex, NothingIsFarFromEverything) {
  EXPECT_TRUE(std::isinf(SequenceIndex(2).nearest_rms(ramp(5, 0, 1))));
  SequenceIndex index(3);
  EXPECT_THROW(index.add(ramp(5, 0, 1)), std::invalid_argument);
  EXPECT_THROW(index.add(AuMatrix(0, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
