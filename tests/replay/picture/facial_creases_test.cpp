#include "replay/picture/facial_creases.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "solve/faces/facial_muscles.h"

namespace {

using namespace risorius;

TEST(FacialCreases, BelongToAusOfTheFaceAndLieOnTheLeftHalf) {
  for (const Crease& crease : facial_creases()) {
    EXPECT_TRUE(std::any_of(facial_muscles().begin(), facial_muscles().end(), [&](const Muscle& muscle) {
      return muscle.au == crease.au;
    })) << crease.au;
    ASSERT_GE(crease.line.size(), 2u) << crease.au;
    for (const Eigen::Vector2d& p : crease.line) {
      EXPECT_GE(p.x(), 0) << crease.au;
      EXPECT_LE(p.x(), 75) << crease.au;
    }
  }
}

TEST(CreaseShade, FoldsTheSideThatActsAndOnlyThat) {
  const CreaseShade left({"AU12L"}, 1), right({"AU12R"}, 1), both({"AU12L", "AU12R"}, 1);
  EXPECT_LT(left.height_mm(32, -22), -0.5) << "the nasolabial fold";
  EXPECT_EQ(left.height_mm(-32, -22), 0);
  EXPECT_EQ(right.height_mm(-32, -22), left.height_mm(32, -22));
  EXPECT_EQ(right.height_mm(32, -22), 0);
  EXPECT_EQ(both.height_mm(-32, -22), left.height_mm(32, -22));
  EXPECT_EQ(left.height_mm(32, 60), 0) << "the brow stays smooth";
}

TEST(CreaseShade, FoldsThatCrossTheMiddleAreNoDeeperThere) {
  const CreaseShade both({"AU1L", "AU1R"}, 1), left({"AU1L"}, 1);
  double at_side = 0;
  for (double y = 66; y < 70; y += 0.1) at_side = std::min(at_side, both.height_mm(8, y));
  for (double x = -6; x <= 6; x += 0.5) {
    double deepest = 0;
    for (double y = 66; y < 70; y += 0.1) deepest = std::min(deepest, both.height_mm(x, y));
    EXPECT_NEAR(deepest, at_side, 0.15 * std::abs(at_side)) << x;
  }
  EXPECT_NEAR(left.height_mm(0, 68), 0.5 * both.height_mm(0, 68), 1e-9);
}

TEST(CreaseShade, GrowsWithTheFace) {
  const CreaseShade one({"AU12L"}, 1), larger({"AU12L"}, 1.1);
  EXPECT_NEAR(larger.height_mm(1.1 * 32, -1.1 * 22), 1.1 * one.height_mm(32, -22), 1e-9);
}

TEST(CreaseShade, NothingFoldsAtRestOrWhereNoCreaseIsKnown) {
  EXPECT_TRUE(CreaseShade({}, 1).empty());
  EXPECT_TRUE(CreaseShade({"AU5L", "AU29", "jawOpen"}, 1).empty());
}

}  // namespace
