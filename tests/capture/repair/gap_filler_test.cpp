#include "capture/repair/gap_filler.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "capture/errors.h"
#include "support/allocation_counter.h"
#include "support/synthetic_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::distance_mm;
using test::hide;
using test::MarkerTake;
using test::run_stage;
using test::synthetic_take;

constexpr FillMethod kMethods[] = {FillMethod::kHold, FillMethod::kDampedVelocity, FillMethod::kCovariance};

std::vector<MarkerFrame> fill(const MarkerTake& take, GapFillerOptions options = {}) {
  GapFiller filler(options);
  filler.use_marker_set(take.set);
  return run_stage(filler, take.frames);
}

std::vector<MarkerFrame> fill(const MarkerTake& take, FillMethod method) {
  GapFillerOptions options;
  options.method = method;
  return fill(take, options);
}

double mean_error_mm(const MarkerTake& truth, const std::vector<MarkerFrame>& filled, std::size_t marker,
                     std::size_t first, std::size_t length) {
  double sum = 0;
  for (std::size_t f = first; f < first + length; ++f) {
    sum += distance_mm(truth.frames[f].position_mm[marker], filled[f].position_mm[marker]);
  }
  return sum / static_cast<double>(length);
}

TEST(GapFiller, LeavesMeasuredSamplesBitEqual) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 200, 60);
  hide(take, 7, 230, 10);
  for (const FillMethod method : kMethods) {
    const auto filled = fill(take, method);
    ASSERT_EQ(filled.size(), take.frames.size());
    for (std::size_t f = 0; f < filled.size(); ++f) {
      for (std::size_t i = 0; i < filled[f].count; ++i) {
        if (take.frames[f].state[i] != MarkerState::kMeasured) continue;
        ASSERT_EQ(filled[f].state[i], MarkerState::kMeasured);
        ASSERT_EQ(filled[f].position_mm[i], take.frames[f].position_mm[i]);
      }
    }
  }
}

TEST(GapFiller, FollowsTheOtherMarkersThroughALongGap) {
  const MarkerTake truth = synthetic_take();
  MarkerTake take = truth;
  hide(take, 3, 400, 90);
  const double covariance = mean_error_mm(truth, fill(take, FillMethod::kCovariance), 3, 400, 90);
  const double hold = mean_error_mm(truth, fill(take, FillMethod::kHold), 3, 400, 90);
  EXPECT_LT(covariance, 0.4 * hold);  // marker 3 moves as three modes that the other 23 show; measured 0.27
}

TEST(GapFiller, HasNoStepAtTheStartOfAGap) {
  const MarkerTake truth = synthetic_take();
  for (const std::size_t marker : {1, 5, 9, 20}) {
    MarkerTake take = truth;
    hide(take, marker, 400, 30);
    const auto filled = fill(take);
    const double moved = distance_mm(truth.frames[399].position_mm[marker], truth.frames[400].position_mm[marker]);
    const double step = distance_mm(filled[399].position_mm[marker], filled[400].position_mm[marker]);
    EXPECT_LT(step - moved, 3 * 0.05 * std::sqrt(3.0)) << marker;  // 3 x the noise of the take
  }
}

TEST(GapFiller, KeepsMarkerMissingAfterMaxGap) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 200, 100);
  for (const FillMethod method : kMethods) {
    GapFillerOptions options;
    options.method = method;
    options.max_gap_ns = 500'000'000;
    const auto filled = fill(take, options);
    EXPECT_EQ(filled[229].state[3], MarkerState::kFilled);  // the 30th frame is 30 / 60 s after the last sample
    EXPECT_EQ(filled[231].state[3], MarkerState::kMissing);
    EXPECT_EQ(filled[299].state[3], MarkerState::kMissing);
    EXPECT_EQ(filled[300].state[3], MarkerState::kMeasured);
  }
}

TEST(GapFiller, StatesAnErrorThatGrowsWithTheGap) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 300, 100);
  for (const FillMethod method : kMethods) {
    const auto filled = fill(take, method);
    EXPECT_GT(filled[300].standard_deviation_mm[3], 0);
    EXPECT_GT(filled[399].standard_deviation_mm[3], 1.2 * filled[300].standard_deviation_mm[3]);
    EXPECT_EQ(filled[299].standard_deviation_mm[3], 0);
  }
}

TEST(GapFiller, FillsRejectedMarkersAndKeepsTheReason) {
  const MarkerTake truth = synthetic_take();
  MarkerTake take = truth;
  take.frames[300].state[4] = MarkerState::kRejected;
  take.frames[300].reason[4] = RejectReason::kGhost;
  take.frames[300].position_mm[4] = {500, 500, 500};
  GapFiller filler;
  filler.use_marker_set(take.set);
  const auto filled = run_stage(filler, take.frames);
  EXPECT_EQ(filled[300].state[4], MarkerState::kFilled);
  EXPECT_EQ(filled[300].reason[4], RejectReason::kGhost);
  EXPECT_LT(distance_mm(filled[300].position_mm[4], truth.frames[300].position_mm[4]), 0.5);
  EXPECT_EQ(filler.filled(RejectReason::kGhost).value(), 1U);
}

TEST(GapFiller, RejectsAndFillsPositionsThatAreNotFinite) {
  MarkerTake take = synthetic_take();
  take.frames[300].position_mm[4].y = std::numeric_limits<float>::quiet_NaN();
  take.frames[301].position_mm[4].z = std::numeric_limits<float>::infinity();
  const auto filled = fill(take);
  for (const std::size_t f : {300, 301}) {
    EXPECT_EQ(filled[f].state[4], MarkerState::kFilled);
    EXPECT_EQ(filled[f].reason[4], RejectReason::kNotFinite);
    EXPECT_TRUE(std::isfinite(filled[f].position_mm[4].y) && std::isfinite(filled[f].position_mm[4].z));
  }
}

TEST(GapFiller, HeadMotionDoesNotChangeTheFill) {
  MarkerTake still = synthetic_take();
  MarkerTake moving = synthetic_take({.head_moves = true});
  hide(still, 3, 400, 60);
  hide(moving, 3, 400, 60);
  for (const FillMethod method : kMethods) {
    const auto of_still = fill(still, method), of_moving = fill(moving, method);
    for (std::size_t f = 400; f < 460; ++f) {
      const Eigen::Isometry3d head = test::synthetic_head(static_cast<double>(f) / 60);
      const Eigen::Vector3d expected = head * test::vector_of(of_still[f].position_mm[3]);
      // Positions are rounded to float at about 150 mm (8e-6 mm); what remains is the rounding of the whole history.
      EXPECT_LT((test::vector_of(of_moving[f].position_mm[3]) - expected).norm(), 2e-3);
    }
  }
}

TEST(GapFiller, SurvivesAWholeFrameDropOutAndAStartInAGap) {
  MarkerTake take = synthetic_take();
  for (std::size_t i = 0; i < 24; ++i) hide(take, i, 300, 20);
  hide(take, 2, 0, 100);
  hide(take, 6, 0, 600);
  const MarkerTake truth = synthetic_take();
  const auto filled = fill(take);
  EXPECT_EQ(filled[50].state[2], MarkerState::kMissing);
  EXPECT_EQ(filled[100].state[2], MarkerState::kMeasured);
  EXPECT_EQ(filled[599].state[6], MarkerState::kMissing);
  for (std::size_t i = 0; i < 24; ++i) {
    if (i == 6) continue;
    EXPECT_EQ(filled[319].state[i], MarkerState::kFilled);
    // Nothing is seen: the last word is held, so the error is at most the way that the marker went meanwhile.
    EXPECT_LT(distance_mm(filled[300].position_mm[i], filled[299].position_mm[i]), 1.0);
    EXPECT_EQ(filled[320].state[i], MarkerState::kMeasured);
  }
}

TEST(GapFiller, SurvivesAClockThatRunsBackOrLeaps) {
  MarkerTake take = synthetic_take();
  hide(take, 3, 200, 20);
  take.frames[205].header.capture_time_ns = 0;
  take.frames[206].header.capture_time_ns = std::numeric_limits<std::int64_t>::max();
  take.frames[207].header.capture_time_ns = std::numeric_limits<std::int64_t>::min();
  for (const MarkerFrame& frame : fill(take)) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      EXPECT_TRUE(test::vector_of(frame.position_mm[i]).allFinite());
      EXPECT_TRUE(std::isfinite(frame.standard_deviation_mm[i]));
    }
  }
}

TEST(GapFiller, SameInputTwiceGivesEqualBits) {
  MarkerTake take = synthetic_take({.head_moves = true});
  hide(take, 3, 200, 60);
  GapFiller filler;
  filler.use_marker_set(take.set);
  const auto first = run_stage(filler, take.frames);
  filler.reset();
  const auto second = run_stage(filler, take.frames);
  for (std::size_t f = 0; f < first.size(); ++f) ASSERT_TRUE(test::same_bits(first[f], second[f])) << f;
}

TEST(GapFiller, AllocatesNothingPerFrame) {
  MarkerTake take = synthetic_take({.markers = 60, .frames = 100});
  hide(take, 3, 40, 30);
  GapFiller filler;
  filler.use_marker_set(take.set);
  MarkerFrame out;
  const std::uint64_t before = test::allocations_of_this_thread();
  for (const MarkerFrame& frame : take.frames) {
    filler.push(frame);
    filler.pop(out);
  }
  filler.flush();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(GapFiller, RemapsItsStateByName) {
  const MarkerTake truth = synthetic_take();
  MarkerTake take = truth;
  GapFiller filler;
  filler.use_marker_set(take.set);
  run_stage(filler, {take.frames.begin(), take.frames.begin() + 400});

  // The same face in reverse order, without M0 and with a newcomer, and M3 hidden from the first frame on.
  MarkerTake turned;
  turned.set.names.assign(truth.set.names.rbegin(), truth.set.names.rend());
  turned.set.names.back() = "Newcomer";
  for (std::size_t f = 400; f < 460; ++f) {
    MarkerFrame& frame = turned.frames.emplace_back(truth.frames[f]);
    for (std::size_t i = 0; i < 24; ++i) frame.position_mm[i] = truth.frames[f].position_mm[23 - i];
    frame.state[20] = MarkerState::kMissing;
  }
  filler.use_marker_set(turned.set);
  const auto filled = run_stage(filler, turned.frames);
  double error = 0;
  for (std::size_t f = 0; f < 60; ++f) {
    ASSERT_EQ(filled[f].state[20], MarkerState::kFilled);
    error += distance_mm(filled[f].position_mm[20], truth.frames[400 + f].position_mm[3]) / 60;
  }
  // A filler that had forgotten could not fill it at all; M3 moves by 4.5 mm on average (the error of hold).
  EXPECT_LT(error, 0.4 * 4.5);
}

TEST(GapFiller, RefusesAFrameOfAnotherCountAndKeepsItsBooks) {
  const MarkerTake take = synthetic_take({.frames = 10});
  GapFiller filler;
  filler.use_marker_set(take.set);
  MarkerFrame odd = take.frames[0];
  odd.count = 5;
  MarkerFrame out;
  EXPECT_TRUE(filler.push(odd));
  EXPECT_FALSE(filler.pop(out));
  EXPECT_TRUE(filler.push(take.frames[0]));
  EXPECT_FALSE(filler.push(take.frames[1]));  // not ready: nothing consumed
  EXPECT_TRUE(filler.ledger().balanced());
  EXPECT_TRUE(filler.pop(out));
  filler.flush();
  EXPECT_EQ(filler.ledger().received.value(), 2U);
  EXPECT_EQ(filler.ledger().refused.value(), 1U);
  EXPECT_EQ(filler.ledger().emitted.value(), 1U);
  EXPECT_EQ(filler.ledger().held.value(), 0U);
}

TEST(GapFiller, RejectsOptionsOutOfRange) {
  EXPECT_THROW(GapFiller({.max_gap_ns = 0}), UserError);
  EXPECT_THROW(GapFiller({.head_frame = {.stabilisers = {{"M1", -1.0}}}}), UserError);
  EXPECT_THROW(GapFiller({.covariance = {.memory_s = 0}}), UserError);
  GapFiller filler;
  EXPECT_THROW(filler.use_marker_set({.names = {"A", "A"}}), UserError);
}

TEST(GapFiller, WorksWithOneMarkerAndWithTheMost) {
  for (const std::size_t markers : {std::size_t{1}, std::size_t{2}, kMaxMarkers}) {
    MarkerTake take = synthetic_take({.markers = markers, .frames = 80});
    hide(take, 0, 60, 5);
    const auto filled = fill(take);
    ASSERT_EQ(filled.size(), 80U);
    EXPECT_EQ(filled[79].state[0], MarkerState::kMeasured);
    EXPECT_EQ(filled[62].state[0], markers < 3 ? MarkerState::kMissing : MarkerState::kFilled);
  }
}

// EVALUATION section 1 in small: the real jaw take, gaps of 30 frames in 12 markers.
TEST(GapFiller, BeatsHoldAndDampedVelocityOnARealTake) {
  RISORIUS_NEEDS_DATA(path, "animface/jaw.csv");
  const MarkerTake truth = test::read_marker_csv(path, 60);
  MarkerTake take = truth;
  for (std::size_t k = 0; k < 12; ++k) hide(take, (7 * k) % 41, 350 + 100 * k, 30);
  double errors[3] = {};
  for (std::size_t m = 0; m < 3; ++m) {
    const auto filled = fill(take, kMethods[m]);
    for (std::size_t k = 0; k < 12; ++k)
      errors[m] += mean_error_mm(truth, filled, (7 * k) % 41, 350 + 100 * k, 30) / 12;
  }
  EXPECT_LT(errors[2], errors[0]);
  EXPECT_LT(errors[2], errors[1]);
}

std::vector<MarkerFrame> fill_with_lookahead(const MarkerTake& take, std::uint32_t frames,
                                             FillMethod method = FillMethod::kCovariance) {
  GapFiller filler({.method = method, .lookahead_frames = frames});
  filler.use_marker_set(take.set);
  std::vector<MarkerFrame> out;
  MarkerFrame popped;
  for (const MarkerFrame& frame : take.frames) {
    EXPECT_TRUE(filler.push(frame));
    while (filler.pop(popped)) out.push_back(popped);
    EXPECT_EQ(filler.ledger().held.value(), std::min<std::size_t>(frames, filler.ledger().received.value()));
    EXPECT_TRUE(filler.ledger().balanced());
  }
  filler.flush();
  while (filler.pop(popped)) out.push_back(popped);
  EXPECT_EQ(filler.ledger().held.value(), 0U);
  return out;
}

TEST(GapFiller, WithLookAheadFramesComeLaterInOrderAndMeasuredSamplesAreTheSame) {
  MarkerTake take = synthetic_take({.frames = 200});
  hide(take, 3, 100, 20);
  const auto at_once = fill_with_lookahead(take, 0), later = fill_with_lookahead(take, 7);
  ASSERT_EQ(later.size(), 200U);
  for (std::size_t f = 0; f < 200; ++f) {
    EXPECT_EQ(later[f].header.sequence, f);
    // Only the last seven frames of the gap know of its end.
    if (f < 113 || f >= 120) {
      EXPECT_TRUE(test::same_bits(at_once[f], later[f])) << f;
    }
  }
}

TEST(GapFiller, WithLookAheadAMarkerIsMetWithASmallerStep) {
  const MarkerTake truth = synthetic_take();
  double without = 0, with = 0;
  for (std::size_t k = 0; k < 8; ++k) {
    MarkerTake take = truth;
    for (std::size_t i = 0; i < 24; i += 2) hide(take, i, 200 + 40 * k, 30);
    const auto at_once = fill_with_lookahead(take, 0, FillMethod::kHold);
    const auto later = fill_with_lookahead(take, 8, FillMethod::kHold);
    for (std::size_t i = 0; i < 24; i += 2) {
      const std::size_t end = 230 + 40 * k;
      without += distance_mm(at_once[end - 1].position_mm[i], truth.frames[end - 1].position_mm[i]);
      with += distance_mm(later[end - 1].position_mm[i], truth.frames[end - 1].position_mm[i]);
    }
  }
  EXPECT_LT(with, 0.3 * without);  // of eight frames the last is led home by 8 / 9
}

TEST(GapFiller, RefusesToLookTooFarAhead) { EXPECT_THROW(GapFiller({.lookahead_frames = 65}), UserError); }

}  // namespace
}  // namespace risorius
