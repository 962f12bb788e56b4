#include "solve/faces/identity_warp.h"

#include <gtest/gtest.h>
#include <random>

namespace {

using namespace risorius;
using Eigen::Vector3d;

std::vector<WarpObservation> pulled(const Vector3d& at_mm, const Vector3d& shift_mm, double deviation_mm) {
  std::vector<WarpObservation> observations;
  for (int axis = 0; axis < 3; ++axis)
    observations.push_back({at_mm, Vector3d::Unit(axis), shift_mm[axis], deviation_mm});
  return observations;
}

const IdentityPrior kPrior{.deviation_mm = 4, .length_mm = 40};

TEST(IdentityWarp, StaysWhereItIsWithoutObservations) {
  EXPECT_EQ(IdentityWarp()({1, 2, 3}), Vector3d(1, 2, 3));
  EXPECT_EQ(IdentityWarp({}, kPrior).jacobian({1, 2, 3}), Eigen::Matrix3d::Identity());
}

TEST(IdentityWarp, GoesWhereAnExactObservationSaysAndNowhereFarAway) {
  const Vector3d at(45, 10, 80), shift(3, -2, 1);
  const IdentityWarp warp(pulled(at, shift, 1e-3), kPrior);
  EXPECT_LT((warp.displacement_mm(at) - shift).norm(), 1e-4);
  EXPECT_LT(warp.displacement_mm({0, 400, 0}).norm(), 1e-9);
}

TEST(IdentityWarp, BelievesADoubtfulObservationByItsShare) {
  const IdentityWarp warp(pulled({300, 0, 0}, {4, 0, 0}, 4), kPrior);  // far from its mirror image
  EXPECT_NEAR(warp.displacement_mm({300, 0, 0}).x(), 2, 1e-9) << "as doubtful as the prior: half";
}

TEST(IdentityWarp, MovesMirrorImagesAsMirrorImages) {
  const IdentityWarp warp(pulled({30, -40, 70}, {2, 3, -4}, 1), kPrior);
  const Vector3d left = warp.displacement_mm({25, -30, 60}), right = warp.displacement_mm({-25, -30, 60});
  EXPECT_GT(left.norm(), 1);
  EXPECT_LT((right - Vector3d(-left.x(), left.y(), left.z())).norm(), 1e-12);
  EXPECT_EQ(warp.displacement_mm({0, -30, 60}).x(), 0) << "the middle stays in the middle";
}

TEST(IdentityWarp, ObservedAlongOneDirectionSaysNothingOfTheOthers) {
  const IdentityWarp warp({{{300, 0, 0}, Vector3d::UnitZ(), 3, 0.1}}, kPrior);
  EXPECT_EQ(warp.displacement_mm({300, 0, 0}).head<2>().norm(), 0);
  EXPECT_NEAR(warp.displacement_mm({300, 0, 0}).z(), 3, 0.01);
}

TEST(IdentityWarp, HasTheJacobianOfItsDisplacement) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<WarpObservation> observations;
  for (int i = 0; i < 20; ++i) {
    const Vector3d at(40 * normal(random), 40 * normal(random), 40 * normal(random));
    observations.push_back(
        {at, Vector3d(normal(random), normal(random), normal(random)).normalized(), 3 * normal(random), 1});
  }
  const IdentityWarp warp(observations, kPrior);
  const Vector3d p(12, -8, 30);
  const Eigen::Matrix3d jacobian = warp.jacobian(p);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = 1e-4 * Vector3d::Unit(axis);
    EXPECT_LT(((warp(p + step) - warp(p - step)) / 2e-4 - jacobian.col(axis)).norm(), 1e-7);
  }
}

}  // namespace
