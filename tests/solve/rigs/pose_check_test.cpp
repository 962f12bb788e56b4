#include "solve/rigs/pose_check.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace risorius {
namespace {

const std::vector<std::string> kAus{"AU4L", "AU4R", "AU12L", "AU12R", "AU27", "Sneer"};
using State = PoseWatch::State;

/// Rest, 0.5 s up, `held_s` held, 0.5 s down, rest: at time t.
double course(double t_s, double held_s = 1) {
  return std::clamp(std::min((t_s - 0.5) / 0.5, (1.5 + held_s - t_s) / 0.5), 0.0, 1.0);
}

PoseFrame frame_at(double t_s, double left, double right, double jaw = 0) {
  PoseFrame frame{t_s, Eigen::VectorXd::Zero(6)};
  frame.x[2] = left;
  frame.x[3] = right;
  frame.x[4] = jaw;
  return frame;
}

/// Plays a smile until the watch has seen enough; the time of that.
double play(PoseWatch& watch, State& state, double left, double right, double seconds = 30) {
  for (double t_s = 0; t_s < seconds; t_s += 0.01) {
    state = watch.add(frame_at(t_s, left * course(t_s), right * course(t_s), 0.2 * course(t_s)));
    if (state != State::kWaiting) return t_s;
  }
  return seconds;
}

TEST(PromptedPoses, SidesAreAskedForTogether) {
  const auto poses = prompted_poses(kAus);
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_EQ(poses[0].name, "AU4");
  EXPECT_EQ(poses[1].name, "AU12");
  EXPECT_EQ(poses[1].aus, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(poses[2].aus, std::vector<std::size_t>{4});
  EXPECT_EQ(poses[3].name, "Sneer");
  const std::vector<std::string> jaw{"AU30L", "AU30R"};
  EXPECT_EQ(prompted_poses(jaw).size(), 2u) << "not to both sides at once";
}

TEST(PoseWatch, IsOverWhenTheFaceIsBackAtRest) {
  PoseWatch watch(kAus, prompted_poses(kAus)[1]);
  EXPECT_TRUE(watch.checks().empty());
  State state;
  const double over_s = play(watch, state, 0.9, 0.8);
  EXPECT_EQ(state, State::kOver);
  // Half way down at 2.25 s, and 0.3 s of rest.
  EXPECT_NEAR(over_s, 2.55, 0.03);
  const auto checks = watch.checks();
  ASSERT_EQ(checks.size(), 2u);
  EXPECT_EQ(checks[0].au, "AU12L");
  EXPECT_NEAR(checks[0].peak, 0.9, 1e-12);
  EXPECT_NEAR(checks[0].other_side_peak, 0.8, 1e-12);
  EXPECT_EQ(checks[0].company, "AU27");
  EXPECT_EQ(verdict_of(checks[0]), "seen");
}

TEST(PoseWatch, WhatIsHeldIsNotOverAndWhatNeverComesTimesOut) {
  PoseWatch held(kAus, prompted_poses(kAus)[1]);
  for (double t_s = 0; t_s < 10; t_s += 0.01) {
    EXPECT_EQ(held.add(frame_at(t_s, course(t_s, 60), course(t_s, 60))), State::kWaiting);
  }
  PoseWatch never(kAus, prompted_poses(kAus)[1], {.longest_s = 5});
  State state;
  EXPECT_NEAR(play(never, state, 0.2, 0.2), 5, 0.02);
  EXPECT_EQ(state, State::kTimedOut);
  EXPECT_EQ(verdict_of(never.checks()[0]), "not seen: again");
}

TEST(PoseWatch, AskedForAgainWhereOneSideIsWeakOrOnlyAFrameLeapt) {
  PoseWatch lopsided(kAus, prompted_poses(kAus)[1]);
  State state;
  play(lopsided, state, 1.0, 0.45);
  EXPECT_EQ(state, State::kOver);
  EXPECT_EQ(verdict_of(lopsided.checks()[1]), "weaker than the other side");
  PoseWatch leap(kAus, prompted_poses(kAus)[1], {.longest_s = 3});
  for (double t_s = 0; t_s < 2.9; t_s += 0.01) {
    const double x = std::abs(t_s - 1) < 0.005 ? 1 : 0;
    ASSERT_EQ(leap.add(frame_at(t_s, x, x)), State::kWaiting) << t_s;
  }
}

TEST(PoseWatch, ALeapBeforeThePoseDoesNotEndIt) {
  PoseWatch watch(kAus, prompted_poses(kAus)[1]);
  State state = State::kWaiting;
  double over_s = 0;
  for (double t_s = 0; t_s < 5 && state == State::kWaiting; t_s += 0.01) {
    const double x = std::abs(t_s - 0.1) < 0.005 ? 1.2 : 0.55 * course(t_s);
    state = watch.add(frame_at(t_s, x, x));
    over_s = t_s;
  }
  EXPECT_EQ(state, State::kOver);
  EXPECT_NEAR(over_s, 2.55, 0.2) << "not while 0.55 is held";
  EXPECT_NEAR(watch.checks()[0].peak, 0.55, 1e-9);
}

TEST(PoseWatch, WhatIsNotObservedNeitherRestsNorPeaks) {
  PoseWatch watch(kAus, prompted_poses(kAus)[1]);
  State state = State::kWaiting;
  double over_s = 0;
  for (double t_s = 0; t_s < 9 && state == State::kWaiting; t_s += 0.01) {
    const double x = t_s > 2 && t_s < 2.6 ? std::nan("") : course(t_s, 3);
    state = watch.add(frame_at(t_s, x, x));
    over_s = t_s;
  }
  EXPECT_NEAR(over_s, 4.55, 0.05);
  PoseWatch sparse(kAus, prompted_poses(kAus)[1], {.longest_s = 4});
  for (double t_s = 0; t_s < 3.9; t_s += 0.2) {  // 5 frames a second, one of them high
    const double x = std::abs(t_s - 1) < 0.05 ? 1 : 0;
    EXPECT_EQ(sparse.add(frame_at(t_s, x, x)), State::kWaiting) << t_s;
  }
}

TEST(PoseWatch, BeginsAnewWhereTimeGoesBack) {
  PoseWatch watch(kAus, prompted_poses(kAus)[1], {.longest_s = 2});
  watch.add(frame_at(50, 1, 1));
  watch.add(frame_at(50.2, 1, 1));
  EXPECT_EQ(watch.add(frame_at(1, 0, 0)), State::kWaiting);
  EXPECT_EQ(watch.frames().size(), 1u);
  EXPECT_EQ(watch.add(frame_at(3.1, 0, 0)), State::kTimedOut);
  EXPECT_EQ(verdict_of(watch.checks()[0]), "not seen: again");
}

}  // namespace
}  // namespace risorius
