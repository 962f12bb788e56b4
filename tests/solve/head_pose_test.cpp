#include "solve/head_pose.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/allocation_counter.h"

namespace risorius {
namespace {

struct Scene {
  std::vector<Eigen::Vector3d> head, world;
  std::vector<double> weights;
  RigidTransform truth;
};

Scene scene(int count, double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Scene s;
  s.truth.rotation = Eigen::Quaterniond(1, normal(random), normal(random), normal(random)).normalized();
  s.truth.translation = {300 * normal(random), 1500, -800};
  for (int i = 0; i < count; ++i) {
    s.head.emplace_back(60 * normal(random), 70 + 20 * normal(random), 30 * normal(random));
    s.world.push_back(s.truth * s.head.back() +
                      noise_mm * Eigen::Vector3d(normal(random), normal(random), normal(random)));
    s.weights.push_back(1);
  }
  return s;
}

/// The largest error over a head of 100 mm radius.
double pose_error_mm(const RigidTransform& a, const RigidTransform& b) {
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d p = 100 * Eigen::Vector3d::Unit(axis);
    worst = std::max({worst, (a * p - b * p).norm(), (a * -p - b * -p).norm()});
  }
  return worst;
}

TEST(HeadPose, RecoversTheMotionExactlyWithoutNoise) {
  HeadPose pose(8, {});
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Scene s = scene(3 + static_cast<int>(seed % 6), 0, seed);
    const HeadPoseResult result = pose.estimate(s.head, s.world, s.weights);
    ASSERT_TRUE(result.determined);
    EXPECT_LT(pose_error_mm(result.world_from_head, s.truth), 1e-9);
    EXPECT_LT(result.residual_rms_mm, 1e-9);
  }
}

TEST(HeadPose, OneStabiliserOffBy20MmDoesNotBendIt) {
  HeadPose pose(6, {});
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (int false_one = 0; false_one < 6; ++false_one) {
      for (int axis = 0; axis < 3; ++axis) {
        Scene s = scene(6, 0.2, seed);
        s.world[false_one] += 20 * Eigen::Vector3d::Unit(axis);
        const HeadPoseResult bent = pose.estimate(s.head, s.world, s.weights);
        s.weights[false_one] = 0;
        const HeadPoseResult without = pose.estimate(s.head, s.world, s.weights);
        ASSERT_TRUE(bent.determined);
        // The outlier's remaining influence is threshold^4 / distance^3, 2^4 / 20^3 = 0.002 mm, times its leverage.
        EXPECT_LT(pose_error_mm(bent.world_from_head, without.world_from_head), 0.1)
            << "seed " << seed << " stabiliser " << false_one << " axis " << axis;
      }
    }
  }
}

TEST(HeadPose, IsUndeterminedFromFewerThanThreeOrCollinearPoints) {
  HeadPose pose(5, {});
  Scene s = scene(5, 0, 1);
  s.weights = {1, 1, 0, 0, 0};
  for (int unused = 2; unused < 5; ++unused) s.world[unused].setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(pose.estimate(s.head, s.world, s.weights).determined);
  EXPECT_FALSE(pose.estimate({}, {}, {}).determined);
  for (int i = 0; i < 5; ++i) {
    s.head[i] = Eigen::Vector3d(i, 2 * i, -i);
    s.world[i] = s.truth * s.head[i];
  }
  s.weights.assign(5, 1);
  EXPECT_FALSE(pose.estimate(s.head, s.world, s.weights).determined);
}

TEST(HeadPose, DoesNotReadPointsOfWeightZero) {
  HeadPose pose(6, {});
  Scene s = scene(6, 0, 2);
  s.weights[4] = 0;
  s.world[4].setConstant(std::numeric_limits<double>::quiet_NaN());
  const HeadPoseResult result = pose.estimate(s.head, s.world, s.weights);
  ASSERT_TRUE(result.determined);
  EXPECT_LT(pose_error_mm(result.world_from_head, s.truth), 1e-9);
}

TEST(HeadPose, AllocatesNothing) {
  HeadPose pose(6, {});
  const Scene s = scene(6, 1, 3);
  const std::uint64_t before = test::allocations_of_this_thread();
  pose.estimate(s.head, s.world, s.weights);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(HeadPose, RefusesOptionsOutOfRange) {
  EXPECT_THROW(HeadPose(6, {.robust_threshold_mm = 0}), std::invalid_argument);
  EXPECT_THROW(HeadPose(6, {.robust_threshold_mm = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
  EXPECT_THROW(HeadPose(6, {.iterations = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
