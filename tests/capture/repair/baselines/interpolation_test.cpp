#include "capture/repair/baselines/interpolation.h"

#include <gtest/gtest.h>

#include "support/synthetic_take.h"

namespace risorius {
namespace {

std::vector<MarkerFrame> straight_way(std::size_t frames) {
  std::vector<MarkerFrame> take(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    take[f].count = 1;
    take[f].header.capture_time_ns = static_cast<std::int64_t>(f) * 10'000'000;
    take[f].state[0] = MarkerState::kMeasured;
    take[f].position_mm[0] = {2.0F * static_cast<float>(f), 1, 0};
  }
  return take;
}

TEST(Interpolation, LinearFillsAStraightWayExactlyAndLeavesTheEndsOpen) {
  const auto truth = straight_way(20);
  auto take = truth;
  for (const std::size_t f : {0, 1, 7, 8, 9, 10, 19})
    take[f].state[0] = MarkerState::kMissing, take[f].position_mm[0] = {};
  fill_linear(take, 1'000'000'000);
  for (std::size_t f = 7; f <= 10; ++f) {
    EXPECT_EQ(take[f].state[0], MarkerState::kFilled);
    EXPECT_LT(test::distance_mm(take[f].position_mm[0], truth[f].position_mm[0]), 1e-5);
    EXPECT_GT(take[f].standard_deviation_mm[0], 0);
  }
  for (const std::size_t f : {0, 1, 19}) EXPECT_EQ(take[f].state[0], MarkerState::kMissing);
}

TEST(Interpolation, LinearLeavesAGapLongerThanTheMaximum) {
  auto take = straight_way(20);
  for (std::size_t f = 5; f < 15; ++f) take[f].state[0] = MarkerState::kMissing;
  fill_linear(take, 100'000'000);  // the ends are 110 ms apart
  EXPECT_EQ(take[9].state[0], MarkerState::kMissing);
  fill_linear(take, 110'000'000);
  EXPECT_EQ(take[9].state[0], MarkerState::kFilled);
}

TEST(Interpolation, CubicFollowsAParabolaAndALineIsNoneOfIt) {
  auto truth = straight_way(20);
  for (std::size_t f = 0; f < 20; ++f) truth[f].position_mm[0].y = 0.1F * static_cast<float>(f * f);
  auto cubic = truth;
  for (std::size_t f = 7; f <= 10; ++f) cubic[f].state[0] = MarkerState::kMissing, cubic[f].position_mm[0] = {};
  auto linear = cubic;
  fill_cubic(cubic, 1'000'000'000);
  fill_linear(linear, 1'000'000'000);
  EXPECT_LT(test::distance_mm(cubic[8].position_mm[0], truth[8].position_mm[0]), 1e-3);
  EXPECT_GT(test::distance_mm(linear[8].position_mm[0], truth[8].position_mm[0]), 0.5);  // 0.1 (8 - 6) (11 - 8)
}

TEST(Interpolation, InTheHeadsFrameTheHeadMayMove) {
  const test::MarkerTake truth = test::synthetic_take({.noise_mm = 0.01, .head_moves = true});
  test::MarkerTake world = truth;
  test::hide(world, 20, 300, 30);  // a marker of the upper half, which moves little about the head
  test::MarkerTake head = world;
  fill_linear(world.frames, 10'000'000'000);
  fill_linear_in_head(head.frames, head.set, 10'000'000'000);
  const auto error = [&](const test::MarkerTake& take) {
    return test::distance_mm(take.frames[315].position_mm[20], truth.frames[315].position_mm[20]);
  };
  EXPECT_LT(error(head), 1);
  EXPECT_GT(error(world), 5);
}

}  // namespace
}  // namespace risorius
