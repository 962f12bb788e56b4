#include "capture/repair/offline_repair.h"

#include <gtest/gtest.h>
#include <limits>

#include "capture/errors.h"
#include "support/synthetic_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::distance_mm;
using test::hide;
using test::MarkerTake;
using test::synthetic_take;

double mean_error_mm(const MarkerTake& truth, const MarkerTake& filled, std::size_t i, std::size_t first,
                     std::size_t length) {
  double sum = 0;
  for (std::size_t f = first; f < first + length; ++f) {
    EXPECT_EQ(filled.frames[f].state[i], MarkerState::kFilled);
    sum += distance_mm(truth.frames[f].position_mm[i], filled.frames[f].position_mm[i]);
  }
  return sum / static_cast<double>(length);
}

TEST(OfflineRepair, BeatsLinearInALongGapAndMeetsBothEnds) {
  const MarkerTake truth = synthetic_take({.head_moves = true});
  MarkerTake regression = truth;
  hide(regression, 3, 200, 90);
  MarkerTake linear = regression;
  fill_offline(regression.frames, truth.set, {});
  fill_offline(linear.frames, truth.set, {.method = OfflineFillMethod::kLinear});
  EXPECT_LT(mean_error_mm(truth, regression, 3, 200, 90), 0.25 * mean_error_mm(truth, linear, 3, 200, 90));
  // Within a frame of the ends the error is that of two noisy samples (0.05 mm per axis) and of a short prediction.
  for (const std::size_t f : {200, 289}) {
    EXPECT_LT(distance_mm(truth.frames[f].position_mm[3], regression.frames[f].position_mm[3]), 0.5);
  }
}

TEST(OfflineRepair, LeavesMeasuredSamplesBitEqual) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 0, 30);
  hide(take, 4, 570, 30);
  hide(take, 5, 100, 30);
  for (std::size_t i = 0; i < 24; ++i) hide(take, i, 300, 5);
  const MarkerTake before = take;
  fill_offline(take.frames, take.set, {});
  for (std::size_t f = 0; f < 600; ++f) {
    for (std::size_t i = 0; i < 24; ++i) {
      if (before.frames[f].state[i] != MarkerState::kMeasured) continue;
      ASSERT_EQ(take.frames[f].state[i], MarkerState::kMeasured);
      ASSERT_EQ(take.frames[f].position_mm[i], before.frames[f].position_mm[i]);
    }
  }
  EXPECT_EQ(take.frames[0].state[3], MarkerState::kFilled);
  EXPECT_EQ(take.frames[599].state[4], MarkerState::kFilled);
}

TEST(OfflineRepair, FillsAWholeFrameDropOutAndATakeThatBeginsInsideAGap) {
  const MarkerTake truth = synthetic_take({.head_moves = true});
  MarkerTake take = truth;
  for (std::size_t i = 0; i < 24; ++i) test::hide(take, i, 300, 4);
  test::hide(take, 5, 0, 40);
  fill_offline(take.frames, take.set, {});
  for (std::size_t i = 0; i < 24; ++i) {
    // The head turns and moves in those 67 ms; its pose is bridged straight.
    EXPECT_LT(mean_error_mm(truth, take, i, 300, 4), 2);
  }
  EXPECT_LT(mean_error_mm(truth, take, 5, 0, 40), 0.5);
}

TEST(OfflineRepair, FillsManyMarkersHiddenAtOnce) {
  const MarkerTake truth = synthetic_take();
  MarkerTake take = truth;
  for (std::size_t i = 0; i < 24; i += 2) test::hide(take, i, 250 + i, 60);
  fill_offline(take.frames, take.set, {});
  for (std::size_t i = 0; i < 24; i += 2) EXPECT_LT(mean_error_mm(truth, take, i, 250 + i, 60), 0.5);
}

TEST(OfflineRepair, SameTakeTwiceGivesTheSameBits) {
  MarkerTake once = synthetic_take();
  hide(once, 3, 100, 50);
  MarkerTake again = once;
  fill_offline(once.frames, once.set, {});
  fill_offline(again.frames, again.set, {});
  for (std::size_t f = 0; f < once.frames.size(); ++f) EXPECT_TRUE(test::same_bits(once.frames[f], again.frames[f]));
}

TEST(OfflineRepair, LeavesATakeWithoutAHead) {
  MarkerTake take = synthetic_take({.markers = 2, .frames = 60});
  hide(take, 1, 20, 5);
  fill_offline(take.frames, take.set, {});
  EXPECT_EQ(take.frames[22].state[1], MarkerState::kMissing);
}

TEST(OfflineRepair, LeavesLongGapsAndMarkersNeverSeen) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 100, 200);
  hide(take, 4, 0, 600);
  fill_offline(take.frames, take.set, {.max_gap_ns = 1'000'000'000});
  EXPECT_EQ(take.frames[200].state[3], MarkerState::kMissing);
  EXPECT_EQ(take.frames[200].state[4], MarkerState::kMissing);
}

TEST(OfflineRepair, FillsWhatIsNotFiniteAndKeepsReasons) {
  MarkerTake take = synthetic_take();
  take.frames[50].position_mm[2].x = std::numeric_limits<float>::quiet_NaN();
  take.frames[51].state[6] = MarkerState::kRejected;
  take.frames[51].reason[6] = RejectReason::kJump;
  for (const OfflineFillMethod method : {OfflineFillMethod::kLinear, OfflineFillMethod::kRegression}) {
    MarkerTake filled = take;
    fill_offline(filled.frames, take.set, {.method = method});
    EXPECT_EQ(filled.frames[50].state[2], MarkerState::kFilled);
    EXPECT_EQ(filled.frames[50].reason[2], RejectReason::kNotFinite);
    EXPECT_TRUE(std::isfinite(filled.frames[50].position_mm[2].x));
    EXPECT_EQ(filled.frames[51].reason[6], RejectReason::kJump);
  }
}

TEST(OfflineRepair, TellsItsProgressAndAcceptsAnEmptyTake) {
  MarkerTake take = synthetic_take();
  std::vector<double> told;
  fill_offline(take.frames, take.set, {.progress = [&](double share) { told.push_back(share); }});
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  std::vector<MarkerFrame> none;
  fill_offline(none, take.set, {});
}

TEST(OfflineRepair, RefusesATakeThatDoesNotFitItsSet) {
  MarkerTake take = synthetic_take({.frames = 5});
  take.frames[3].count = 7;
  EXPECT_THROW(fill_offline(take.frames, take.set, {}), UserError);
  EXPECT_THROW(fill_offline(take.frames, take.set, {.max_gap_ns = -1}), UserError);
}

// EVALUATION section 1 in small: the real jaw take, gaps of 30 frames in 12 markers.
TEST(OfflineRepair, BeatsLinearOnARealTake) {
  RISORIUS_NEEDS_DATA(path, "animface/jaw.csv");
  const MarkerTake truth = test::read_marker_csv(path, 60);
  MarkerTake regression = truth;
  for (std::size_t k = 0; k < 12; ++k) hide(regression, (7 * k) % 41, 350 + 100 * k, 30);
  MarkerTake linear = regression;
  fill_offline(regression.frames, truth.set, {});
  fill_offline(linear.frames, truth.set, {.method = OfflineFillMethod::kLinear});
  double of_regression = 0, of_linear = 0;
  for (std::size_t k = 0; k < 12; ++k) {
    of_regression += mean_error_mm(truth, regression, (7 * k) % 41, 350 + 100 * k, 30);
    of_linear += mean_error_mm(truth, linear, (7 * k) % 41, 350 + 100 * k, 30);
  }
  EXPECT_LT(of_regression, of_linear);
}

}  // namespace
}  // namespace risorius
