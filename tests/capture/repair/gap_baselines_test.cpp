#include "capture/repair/gap_baselines.h"

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

TEST(GapBaselines, LinearFillsAStraightWayExactlyAndLeavesTheEndsOpen) {
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

TEST(GapBaselines, LinearLeavesAGapLongerThanTheMaximum) {
  auto take = straight_way(20);
  for (std::size_t f = 5; f < 15; ++f) take[f].state[0] = MarkerState::kMissing;
  fill_linear(take, 100'000'000);  // the ends are 110 ms apart
  EXPECT_EQ(take[9].state[0], MarkerState::kMissing);
  fill_linear(take, 110'000'000);
  EXPECT_EQ(take[9].state[0], MarkerState::kFilled);
}

TEST(GapBaselines, DampedVelocityGoesOnAndComesToRest) {
  HeldMarker marker;
  for (int f = 0; f < 100; ++f) marker.observe({100.0 * 0.01 * f, 0, 0}, 0.01);  // 100 mm/s
  const double last = marker.hold_mm().x();
  marker.miss(0.01);
  EXPECT_NEAR(marker.damped_mm().x() - last, 0.1 * (1 - std::exp(-0.1)) * 100, 0.01);
  marker.miss(10);
  EXPECT_NEAR(marker.damped_mm().x() - last, HeldMarker::kDampingS * 100, 0.01);
  EXPECT_EQ(marker.hold_mm().x(), last);
}

}  // namespace
}  // namespace risorius
