#include "capture/repair/known_motion.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

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
  const auto motion = face();
  for (const double scale : {1.8, -1.0}) {
    KnownModes modes;
    modes.use(motion, motion->marker_names);
    for (Eigen::Index i = 0; i < 5; ++i) {
      modes.see(static_cast<std::size_t>(i), scale * motion->rest_mm.col(i));
    }
    modes.align();
    EXPECT_FALSE(modes.knows(0)) << scale;
  }
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
