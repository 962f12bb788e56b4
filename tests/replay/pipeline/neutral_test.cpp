#include "replay/pipeline/neutral.h"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "capture/errors.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/rig_fit.h"

namespace {

using namespace risorius;

/// A take out of frames in memory.
class ListTake : public TakeReader {
 public:
  explicit ListTake(std::vector<MarkerFrame> frames) : frames_(std::move(frames)) {
    info_.path = "list";
    for (std::uint32_t m = 0; m < frames_.at(0).count; ++m)
      info_.markers.names.push_back(std::string("M").append(std::to_string(m)));
  }
  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override {
    if (next_ == frames_.size()) return false;
    frame = frames_[next_++];
    return true;
  }
  void rewind() override { next_ = 0; }

 private:
  std::vector<MarkerFrame> frames_;
  std::size_t next_ = 0;
  TakeInfo info_;
};

/// Five markers under a head that turns and drifts from frame to frame.
std::vector<MarkerFrame> moving_head(int frame_count) {
  std::vector<MarkerFrame> frames(static_cast<std::size_t>(frame_count));
  Eigen::Matrix3Xd face(3, 5);
  face << 30, -30, 0, 25, -25, 35, 36, 0, -40, -42, 80, 80, 120, 95, 96;
  for (int f = 0; f < frame_count; ++f) {
    MarkerFrame& frame = frames[static_cast<std::size_t>(f)];
    frame.count = 5;
    const Eigen::AngleAxisd turn(0.01 * f, Eigen::Vector3d(0.3, 1, 0.2).normalized());
    for (std::size_t m = 0; m < 5; ++m) {
      const Eigen::Vector3d p = turn * face.col(static_cast<Eigen::Index>(m)) + Eigen::Vector3d(f, 2 * f, 0);
      frame.position_mm[m] = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
      frame.state[m] = MarkerState::kMeasured;
    }
  }
  return frames;
}

TEST(Neutral, TakesTheHeadsMotionOut) {
  const std::vector<MarkerFrame> frames = moving_head(30);
  ListTake take(frames);
  const Neutral neutral = neutral_of(take, 0, 29);
  EXPECT_EQ(neutral.frame_count, 30u);
  EXPECT_LT(neutral.motion_rms_mm, 1e-4);
  for (std::size_t m = 0; m < 5; ++m) {
    const Position& p = frames[0].position_mm[m];
    EXPECT_LT((neutral.position_mm.col(static_cast<Eigen::Index>(m)) - Eigen::Vector3d(p.x, p.y, p.z)).norm(), 1e-4);
    EXPECT_EQ(neutral.measured_count[m], 30u);
  }
}

TEST(Neutral, MedianIgnoresAFewFalseTracks) {
  std::vector<MarkerFrame> frames = moving_head(31);
  for (const std::size_t f : {5u, 6u, 20u}) frames[f].position_mm[2].x += 20;
  ListTake take(frames);
  const Neutral neutral = neutral_of(take, 0, 30);
  const Position& p = frames[0].position_mm[2];
  EXPECT_LT((neutral.position_mm.col(2) - Eigen::Vector3d(p.x, p.y, p.z)).norm(), 0.01);
}

TEST(Neutral, CountsWhatItSawAndLeavesTheUnseenNaN) {
  std::vector<MarkerFrame> frames = moving_head(20);
  for (std::size_t f = 0; f < 20; ++f) frames[f].state[4] = MarkerState::kMissing;
  frames[3].state[0] = MarkerState::kRejected;
  frames[4].position_mm[1].y = std::numeric_limits<float>::quiet_NaN();
  ListTake take(frames);
  const Neutral neutral = neutral_of(take, 0, 19);
  EXPECT_EQ(neutral.measured_count, (std::vector<std::uint64_t>{19, 19, 20, 20, 0}));
  EXPECT_TRUE(neutral.position_mm.col(4).array().isNaN().all());
  EXPECT_TRUE(neutral.position_mm.leftCols(4).allFinite());
}

TEST(Neutral, SkipsFramesThatCannotBeAligned) {
  std::vector<MarkerFrame> frames = moving_head(10);
  for (std::size_t m = 0; m < 3; ++m) frames[0].state[m] = frames[7].state[m] = MarkerState::kMissing;
  ListTake take(frames);
  const Neutral neutral = neutral_of(take, 0, 9);
  EXPECT_EQ(neutral.frame_count, 8u);
  EXPECT_EQ(neutral.skipped_count, 2u);
}

TEST(Neutral, UsesOnlyTheRangeFromWhereverTheTakeStands) {
  const std::vector<MarkerFrame> frames = moving_head(10);
  ListTake take(frames);
  MarkerFrame ignored;
  take.next(ignored);
  const Neutral neutral = neutral_of(take, 4, 4);
  EXPECT_EQ(neutral.frame_count, 1u);
  EXPECT_EQ(neutral.position_mm(0, 2), frames[4].position_mm[2].x);
}

TEST(Neutral, RefusesRangesThatAreNotThere) {
  ListTake take(moving_head(10));
  EXPECT_THROW(neutral_of(take, 5, 4), UserError);
  EXPECT_THROW(neutral_of(take, 0, 10), UserError);
  EXPECT_THROW(neutral_of(take, 0, 1'000'000), UserError);
  std::vector<MarkerFrame> blind = moving_head(3);
  for (MarkerFrame& frame : blind) frame.state.fill(MarkerState::kMissing);
  ListTake blind_take(blind);
  EXPECT_THROW(neutral_of(blind_take, 0, 2), UserError);
}

TEST(Neutral, OfThePerformerFitsTheBuiltinFaceAgain) {
  PerformerOptions options;
  options.seconds = 2;
  const Rig rig = builtin_rig();
  PerformerTake take(rig, options);
  // The performer's first second is neutral but for a blink: frames 0 to 50 lie before any (0.6 s at 120 Hz is 72).
  const Neutral neutral = neutral_of(take, 0, 50);
  const RigFitResult fit =
      fit_rig(builtin_face(), neutral.marker_names, neutral.position_mm, find_landmark_map("iemocap55"));
  EXPECT_NEAR(fit.scale, 1, 0.005);
  EXPECT_LT(
      (fit.rig.neutral_mm - rig.neutral_mm).colwise().norm().maxCoeff(),
      0.8);  // noise 0.1 mm, median of 51; closest points leave the head's pitch uncertain by a quarter of a degree
  ASSERT_EQ(fit.rig.au_count(), rig.au_count());
  for (std::size_t k = 0; k < rig.au_count(); ++k) {
    EXPECT_LT((fit.rig.aus[k].displacement_mm - rig.aus[k].displacement_mm).colwise().norm().maxCoeff(), 0.5)
        << rig.aus[k].name;
  }
}

}  // namespace
