#include "solve/rigs/rig_check.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "solve/rigs/rom_check.h"
#include "synthetic_face.h"

namespace risorius {
namespace {

constexpr int kAus = 8;

TakeFrames take_of(const Rig& rig) {
  TakeFrames take{"take", test::marker_set_of(rig), {}};
  for (int t = 0; t < 40; ++t) {
    const Eigen::VectorXd x = test::smooth_intensities(static_cast<int>(rig.au_count()), t / 10.0);
    take.frames.push_back(test::marker_frame(rig, x, {}, static_cast<std::uint64_t>(t)));
  }
  return take;
}

bool mentions(const std::vector<std::string>& sentences, const std::string& word) {
  return std::ranges::any_of(sentences, [&](const std::string& s) { return s.find(word) != std::string::npos; });
}

TEST(RigCheck, FindsNothingWrongWithARigAndItsTake) {
  const Rig rig = test::synthetic_rig(40, kAus);
  const RigCheck check = check_rig(rig, take_of(rig));
  EXPECT_TRUE(check.problems.empty());
  EXPECT_TRUE(check.warnings.empty());
  EXPECT_EQ(check.solved, 40u);
  EXPECT_EQ(check.aus.size(), static_cast<std::size_t>(kAus));
}

TEST(RigCheck, NamesAusThatLookAlike) {
  Rig rig = test::synthetic_rig(40, kAus);
  rig.aus[3].displacement_mm = 0.8 * rig.aus[0].displacement_mm;
  const RigCheck check = check_rig(rig, take_of(rig));
  ASSERT_FALSE(check.confused.empty());
  EXPECT_EQ(check.confused[0].first, rig.aus[0].name);
  EXPECT_EQ(check.confused[0].second, rig.aus[3].name);
  EXPECT_NEAR(check.confused[0].cosine, 1, 1e-6);
  EXPECT_TRUE(check.aus[0].weak && check.aus[3].weak);
  EXPECT_LT(check.aus[0].alone_deviation, 0.15);
  EXPECT_GT(check.condition, 1e3);
}

TEST(RigCheck, AnAuThatIsAMotionOfTheHeadIsWeaklyObserved) {
  Rig rig = test::synthetic_rig(40, kAus);
  for (Eigen::Index m = 0; m < 40; ++m) rig.aus[2].displacement_mm.col(m) = Eigen::Vector3d(0, 0, 5);  // a shift
  EXPECT_TRUE(check_rig(rig, take_of(rig)).aus[2].weak);
}

TEST(RigCheck, NamesAStabiliserThatMoves) {
  const Rig rig = test::synthetic_rig(40, kAus);
  TakeFrames take = take_of(rig);
  for (std::size_t t = 10; t < take.frames.size(); ++t) take.frames[t].position_mm[1].y += 5;
  EXPECT_TRUE(mentions(check_rig(rig, take).warnings, "stabiliser M1 moves"));
}

TEST(RigCheck, SaysWhichMarkersAreNeverSeenAndWhichItDoesNotKnow) {
  const Rig rig = test::synthetic_rig(40, kAus);
  TakeFrames take = take_of(rig);
  take.markers.names[20] = "stranger";
  for (MarkerFrame& frame : take.frames) frame.state[30] = MarkerState::kMissing;
  const RigCheck check = check_rig(rig, take);
  EXPECT_EQ(check.missing_markers, (std::vector<std::string>{"M20", "M30"}));
  EXPECT_EQ(check.unknown_markers, std::vector<std::string>{"stranger"});
}

TEST(RigCheck, SaysThatATakeIsMirrored) {
  const Rig rig = test::synthetic_rig(40, kAus);
  TakeFrames take = take_of(rig);
  for (MarkerFrame& frame : take.frames) {
    for (std::size_t m = 0; m < 40; ++m) frame.position_mm[m].x *= -1;
  }
  // The synthetic face is nearly symmetric but for its names: its mirror image is another face or a mirrored one.
  EXPECT_FALSE(check_rig(rig, take).problems.empty());
}

TEST(RomCheck, SaysWhichPosesTheTakeHas) {
  const Rig rig = test::synthetic_rig(40, kAus);  // AU1L, AU1R, ...
  TakeFrames take{"take", test::marker_set_of(rig), {}};
  for (int t = 0; t < 120; ++t) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kAus);
    x[0] = t > 30 && t < 60 ? 0.9 : 0;
    x[1] = t > 30 && t < 60 ? 0.42 : 0;
    x[4] = t == 80 ? 1 : 0;  // one frame is no pose
    take.frames.push_back(test::marker_frame(rig, x, {}, static_cast<std::uint64_t>(t)));
  }
  const auto poses = check_range_of_motion(rig, take);
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kAus));
  EXPECT_TRUE(poses[0].is_seen);
  EXPECT_NEAR(poses[0].peak, 0.9, 0.08);
  EXPECT_GT(poses[0].peak_s, 0.4);
  EXPECT_LT(poses[0].peak_s, 1.0);
  EXPECT_TRUE(poses[1].is_lopsided);
  EXPECT_FALSE(poses[4].is_seen);
  EXPECT_FALSE(poses[6].is_seen);
}

TEST(RigCheck, RefusesATakeOfOtherMarkers) {
  const Rig rig = test::synthetic_rig(40, kAus);
  TakeFrames take = take_of(rig);
  for (std::string& name : take.markers.names) name = "other" + name;
  EXPECT_THROW(check_rig(rig, take), UserError);
}

}  // namespace
}  // namespace risorius
