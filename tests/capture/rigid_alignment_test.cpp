#include "capture/rigid_alignment.h"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace risorius {
namespace {

std::vector<Eigen::Vector3d> random_points(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 50);
  std::vector<Eigen::Vector3d> points(count);
  for (auto& p : points) p = {normal(random), normal(random), normal(random)};
  return points;
}

TEST(RigidAlignment, RecoversEveryRotation) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const auto from = random_points(12, seed);
    const RigidTransform truth{Eigen::Quaterniond::UnitRandom(), Eigen::Vector3d(1000, -20, 3)};
    std::vector<Eigen::Vector3d> to;
    for (const auto& p : from) to.push_back(truth * p);
    const auto found = align_rigid(from, to, std::vector<double>(from.size(), 1.0));
    ASSERT_TRUE(found.determined);
    for (const auto& p : from) EXPECT_LT((found.to_from * p - truth * p).norm(), 1e-9);
    EXPECT_LT((found.to_from.inverse() * (found.to_from * from[0]) - from[0]).norm(), 1e-9);
    EXPECT_LT(found.rms, 1e-9);
  }
}

TEST(RigidAlignment, NeverMirrors) {
  const auto from = random_points(12, 7);
  auto to = from;
  for (auto& p : to) p.x() = -p.x();
  const auto found = align_rigid(from, to, std::vector<double>(from.size(), 1.0));
  EXPECT_NEAR(found.to_from.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  EXPECT_GT(found.rms, 1);
}

TEST(RigidAlignment, IgnoresPointsOfWeightZero) {
  auto from = random_points(5, 3);
  auto to = from;
  from[2].setConstant(std::nan(""));
  const std::vector<double> weights{1, 1, 0, 2, 1};
  const auto found = align_rigid(from, to, weights);
  EXPECT_TRUE(found.determined);
  EXPECT_LT(found.rms, 1e-9);
}

TEST(RigidAlignment, SaysWhenPointsAreOnOneLine) {
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_FALSE(align_rigid(line, line, std::vector<double>(3, 1.0)).determined);
  const std::vector<Eigen::Vector3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_TRUE(align_rigid(flat, flat, std::vector<double>(3, 1.0)).determined);
  EXPECT_FALSE(align_rigid(flat, flat, std::vector<double>{1, 1, 0}).determined);
}

}  // namespace
}  // namespace risorius
