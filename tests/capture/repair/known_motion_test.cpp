#include "capture/repair/known_motion.h"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

namespace risorius {
namespace {

std::shared_ptr<KnownMotion> face() {
  auto motion = std::make_shared<KnownMotion>();
  motion->marker_names = {"brow", "nose", "left", "right", "chin"};
  motion->rest_mm.resize(3, 5);
  motion->rest_mm << 5, 0, 40, -40, 0,  //
      50, 0, -30, -32, -70,             //
      10, 30, 0, 2, 5;
  motion->modes_mm.assign(1, Eigen::Matrix3Xd::Zero(3, 5));
  motion->modes_mm[0].col(4) = Eigen::Vector3d(0, -10, -3);
  return motion;
}

/// 20 markers as on a face; all move alike.
std::shared_ptr<KnownMotion> half_ellipsoid() {
  auto motion = std::make_shared<KnownMotion>();
  motion->rest_mm.resize(3, 20);
  for (Eigen::Index i = 0; i < 20; ++i) {
    motion->marker_names.push_back(std::to_string(i));
    const auto at = static_cast<double>(i);
    const double height = -0.95 + 0.1 * at, turn = 1.4 * std::sin(2.4 * at), radius = std::sqrt(1 - height * height);
    motion->rest_mm.col(i) = Eigen::Vector3d(70 * radius * std::sin(turn), 90 * height, 70 * radius * std::cos(turn));
  }
  motion->modes_mm.assign(1, Eigen::Matrix3Xd::Constant(3, 20, 5));
  return motion;
}

TEST(KnownModes, AreTurnedIntoTheAxesInWhichTheFaceIsSeen) {
  const auto motion = face();
  KnownModes modes;
  const std::vector<std::string> names{"chin", "other", "brow", "nose", "left", "right"};
  modes.use(motion, names);
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(-1.1, Eigen::Vector3d(2, 1, 1).normalized()).toRotationMatrix();
  modes.see(1, {1000, 0, 0});
  for (const auto& [i, column] : {std::pair{0, 4}, {2, 0}, {3, 1}, {4, 2}}) {
    modes.align();
    EXPECT_FALSE(modes.knows(static_cast<std::size_t>(i)));  // three are too few
    modes.see(static_cast<std::size_t>(i), turned * motion->rest_mm.col(column) + Eigen::Vector3d(1, 2, 3));
  }
  modes.align();
  ASSERT_TRUE(modes.knows(0));
  EXPECT_FALSE(modes.knows(1));
  EXPECT_TRUE(modes.knows(5));  // known, though not seen so far
  EXPECT_LT((modes.of(0).transpose() - turned * motion->modes_mm[0].col(4)).norm(), 1e-9);
  EXPECT_EQ(modes.of(2).norm(), 0);
  modes.reset();
  EXPECT_FALSE(modes.knows(0));
}

TEST(KnownModes, OfAnotherFaceOrAMirroredOneAreNotBelieved) {
  const auto motion = half_ellipsoid();
  for (const Eigen::Vector3d& scale : {Eigen::Vector3d(1.6, 1.6, 1.6), Eigen::Vector3d(-1, 1, 1)}) {
    KnownModes modes;
    modes.use(motion, motion->marker_names);
    for (Eigen::Index i = 0; i < 20; ++i) {
      modes.see(static_cast<std::size_t>(i), motion->rest_mm.col(i).cwiseProduct(scale));
    }
    modes.align();
    EXPECT_FALSE(modes.knows(0)) << scale.transpose();
    EXPECT_TRUE(modes.refused()) << scale.transpose();
  }
}

TEST(KnownModes, AFalseTrackDoesNotTurnThem) {
  const auto motion = half_ellipsoid();
  KnownModes modes;
  modes.use(motion, motion->marker_names);
  for (std::size_t i = 0; i < 20; ++i) modes.see(i, motion->rest_mm.col(static_cast<Eigen::Index>(i)));
  modes.see(0, motion->rest_mm.col(19));  // swapped
  modes.see(19, motion->rest_mm.col(0));
  modes.align();
  ASSERT_TRUE(modes.knows(7));
  EXPECT_LT((modes.of(7).transpose() - Eigen::Vector3d::Constant(5)).norm(), 0.1);
}

TEST(KnownModes, OfNobodyKnowNothing) {
  KnownModes modes;
  modes.use(nullptr, {"a", "b", "c", "d"});
  for (std::size_t i = 0; i < 4; ++i) modes.see(i, {static_cast<double>(i * i), static_cast<double>(i), 0});
  modes.align();
  EXPECT_FALSE(modes.knows(0));
  EXPECT_EQ(modes.count(), 0);
}

}  // namespace
}  // namespace risorius
