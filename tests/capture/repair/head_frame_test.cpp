#include "capture/repair/head_frame.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/synthetic_take.h"

namespace risorius {
namespace {

using test::MarkerTake;
using test::synthetic_take;

/// How far the found frame is off the true head, after the constant offset of the first frame: worst over the take.
double worst_error_mm(const MarkerTake& take, HeadFrameOptions options = {}) {
  HeadFrame head(options);
  head.use_names(take.set.names);
  const Eigen::Vector3d probe_head(0, 60, 50);  // the forehead
  Eigen::Vector3d first;
  double worst = 0;
  for (std::size_t f = 0; f < take.frames.size(); ++f) {
    if (!head.process(take.frames[f])) continue;
    const Eigen::Vector3d found =
        head.head_from_world() * (test::synthetic_head(static_cast<double>(f) / 60) * probe_head);
    if (f == 0) first = found;
    worst = std::max(worst, (found - first).norm());
    head.learn(1.0 / 60, head.measured());
  }
  return worst;
}

TEST(HeadFrame, FollowsTheHeadAndNotTheFace) {
  // The lower half of the face moves by 5 to 10 mm; the forehead is still to 0.3 mm.
  EXPECT_LT(worst_error_mm(synthetic_take({.head_moves = true})), 1.5);
}

TEST(HeadFrame, IsNotBentByAFalseTrack) {
  MarkerTake take = synthetic_take({.head_moves = true});
  const double clean = worst_error_mm(take);
  for (std::size_t f = 100; f < 110; ++f) take.frames[f].position_mm[20].x += 80;
  EXPECT_LT(worst_error_mm(take), clean + 0.3);
}

TEST(HeadFrame, UsesGivenStabilisersOnly) {
  MarkerTake take = synthetic_take({.head_moves = true});
  const HeadFrameOptions options{.stabilisers = {{"M20", 1}, {"M21", 1}, {"M22", 1}, {"M23", 1}, {"Absent", 1}}};
  const double clean = worst_error_mm(take, options);
  for (MarkerFrame& frame : take.frames) frame.position_mm[2].x += 0.1F * static_cast<float>(frame.header.sequence);
  EXPECT_EQ(worst_error_mm(take, options), clean);
}

TEST(HeadFrame, HoldsThePoseWhereItIsNotDetermined) {
  const MarkerTake take = synthetic_take({.frames = 20, .head_moves = true});
  HeadFrame head;
  head.use_names(take.set.names);
  for (const MarkerFrame& frame : take.frames) head.process(frame);
  const RigidTransform last = head.head_from_world();
  MarkerFrame two = take.frames[3];
  std::fill(two.state.begin() + 2, two.state.end(), MarkerState::kMissing);
  EXPECT_FALSE(head.process(two));
  EXPECT_EQ(head.head_from_world().translation, last.translation);
}

TEST(HeadFrame, WaitsForAReferenceThatIsCompleteEnough) {
  MarkerTake take = synthetic_take({.frames = 3});
  for (std::size_t i = 0; i < 12; ++i) test::hide(take, i, 0, 1);  // half of them
  HeadFrame head;
  head.use_names(take.set.names);
  EXPECT_FALSE(head.process(take.frames[0]));
  EXPECT_TRUE(head.process(take.frames[1]));
}

TEST(HeadFrame, RejectsOptionsOutOfRange) {
  EXPECT_THROW(HeadFrame({.reference_completeness = 0}), UserError);
  EXPECT_THROW(HeadFrame({.memory_s = -1}), UserError);
}

/// A tracker that pauses for an hour: the one frame after it must not throw the reference about.
TEST(HeadFrame, IsNotThrownOffByALeapInTime) {
  const std::vector<std::string> names{"a", "b", "c", "d"};
  HeadFrame head;
  head.use_names(names);
  const std::vector<std::uint8_t> trusted(4, 1);
  MarkerFrame frame;
  frame.count = 4;
  const float shape[4][3] = {{0, 0, 0}, {80, 0, 0}, {0, 60, 0}, {30, 20, 40}};
  const auto pose = [&](float d_x) {
    for (std::size_t i = 0; i < 4; ++i) {
      frame.state[i] = MarkerState::kMeasured;
      frame.position_mm[i] = {shape[i][0] + (i == 3 ? d_x : 0), shape[i][1], shape[i][2]};
    }
  };
  pose(0);
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(head.process(frame));
    head.learn(0.01, trusted);
  }
  const Eigen::Vector3d before = head.position_head_mm()[3];
  pose(5);
  ASSERT_TRUE(head.process(frame));
  head.learn(3600, trusted);
  pose(0);
  ASSERT_TRUE(head.process(frame));
  EXPECT_LT((head.position_head_mm()[3] - before).norm(), 0.5);
}

}  // namespace
}  // namespace risorius
