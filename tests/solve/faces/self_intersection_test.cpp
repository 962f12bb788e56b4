#include "solve/faces/self_intersection.h"

#include <gtest/gtest.h>

namespace {

using namespace risorius;

/// A triangle in the plane z = 0 and one through it along x, shifted by `shift_mm` in z.
Eigen::Matrix3Xd crossing(double shift_mm) {
  Eigen::Matrix3Xd v(3, 6);
  v.col(0) = Eigen::Vector3d(-10, -10, 0);
  v.col(1) = Eigen::Vector3d(10, -10, 0);
  v.col(2) = Eigen::Vector3d(0, 10, 0);
  v.col(3) = Eigen::Vector3d(-1, 0, -3 + shift_mm);
  v.col(4) = Eigen::Vector3d(1, 0, -3 + shift_mm);
  v.col(5) = Eigen::Vector3d(0, 0.5, 3 + shift_mm);
  return v;
}

Eigen::Matrix3Xi two_triangles() {
  Eigen::Matrix3Xi t(3, 2);
  t << 0, 3, 1, 4, 2, 5;
  return t;
}

TEST(SelfIntersections, FindsACutAndNoCutBeyondReach) {
  const auto found = self_intersections(crossing(0), two_triangles(), 2);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], std::pair(0, 1));
  EXPECT_TRUE(self_intersections(crossing(3.001), two_triangles(), 2).empty());
  EXPECT_TRUE(self_intersections(crossing(-3.001), two_triangles(), 2).empty());
  EXPECT_EQ(self_intersections(crossing(2.999), two_triangles(), 2).size(), 1u);
}

TEST(SelfIntersections, TouchingAndNeighboursDoNotCount) {
  EXPECT_TRUE(self_intersections(crossing(3), two_triangles(), 2).empty());
  Eigen::Matrix3Xi neighbours(3, 2);
  neighbours << 0, 0, 1, 4, 2, 5;
  EXPECT_TRUE(self_intersections(crossing(0), neighbours, 2).empty());
}

TEST(SelfIntersections, LooksAtTheFirstTrianglesOnlyAndStopsAtTheLimit) {
  EXPECT_TRUE(self_intersections(crossing(0), two_triangles(), 1).empty());
  Eigen::Matrix3Xd v(3, 9);
  v.leftCols(6) = crossing(0);
  v.rightCols(3) = crossing(1).rightCols(3);
  v.row(0).tail(3).array() += 4;
  Eigen::Matrix3Xi t(3, 3);
  t << 0, 3, 6, 1, 4, 7, 2, 5, 8;
  EXPECT_EQ(self_intersections(v, t, 3).size(), 2u);
  EXPECT_EQ(self_intersections(v, t, 3, 1).size(), 1u);
}

TEST(FlippedTriangles, FindsOneTurnedOverAndOneCollapsed) {
  // A fan of six triangles about the origin.
  Eigen::Matrix3Xd rest(3, 7);
  Eigen::Matrix3Xi fan(3, 6);
  rest.col(0).setZero();
  for (int k = 0; k < 6; ++k) {
    const double angle = k * 1.0471975511965976;
    rest.col(k + 1) = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    fan.col(k) = Eigen::Vector3i(0, k + 1, (k + 1) % 6 + 1);
  }
  EXPECT_TRUE(flipped_triangles(rest, rest, fan, 6).empty());
  Eigen::Matrix3Xd moved = rest;
  moved.col(0) = Eigen::Vector3d(1.2, 0.7, 0);  // beyond the edge from vertex 1 to 2: its triangle lies face down
  const Eigen::Matrix3Xi alone = fan.leftCols(1);
  EXPECT_EQ(flipped_triangles(rest, moved, fan, 6), std::vector<int>{0});
  moved.col(0) = 0.5 * (rest.col(1) + rest.col(2));
  EXPECT_EQ(flipped_triangles(rest, moved, alone, 1), std::vector<int>{0});
}

}  // namespace
