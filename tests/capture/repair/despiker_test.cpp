#include "capture/repair/despiker.h"

#include <gtest/gtest.h>
#include <limits>

#include "capture/errors.h"
#include "support/allocation_counter.h"
#include "support/marker_defects.h"
#include "support/synthetic_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::MarkerTake;
using test::run_stage;
using test::synthetic_take;

std::vector<MarkerFrame> despike(const MarkerTake& take, DespikerOptions options = {}) {
  Despiker despiker(options);
  despiker.use_marker_set(take.set);
  return run_stage(despiker, take.frames);
}

std::size_t rejected_count(const std::vector<MarkerFrame>& frames) {
  std::size_t count = 0;
  for (const MarkerFrame& frame : frames) {
    count += static_cast<std::size_t>(std::count(frame.state.begin(), frame.state.end(), MarkerState::kRejected));
  }
  return count;
}

void displace(MarkerTake& take, std::size_t f, std::size_t i, float by_mm) { take.frames[f].position_mm[i].z += by_mm; }

TEST(Despiker, AlwaysRejectsAJumpOf20MmAndTakesTheMarkerBack) {
  for (std::size_t marker = 0; marker < 24; ++marker) {
    MarkerTake take = synthetic_take();
    for (std::size_t f = 300; f < 304; ++f) displace(take, f, marker, 20);
    const auto judged = despike(take);
    for (std::size_t f = 300; f < 304; ++f) {
      EXPECT_EQ(judged[f].state[marker], MarkerState::kRejected) << marker;
      EXPECT_NE(judged[f].reason[marker], RejectReason::kNone);
    }
    EXPECT_EQ(judged[304].state[marker], MarkerState::kMeasured) << marker;
    EXPECT_EQ(rejected_count(judged), 4U);
  }
}

// No model knows a movement that was never made before; but it comes step by step, as no false track does.
TEST(Despiker, KeepsALoneMovementThatNothingForetoldAndRejectsTheSameAsALeap) {
  MarkerTake steady = synthetic_take();
  for (std::size_t f = 300; f < 600; ++f) displace(steady, f, 5, std::min(12.0F, 1.5F * static_cast<float>(f - 299)));
  EXPECT_EQ(rejected_count(despike(steady)), 0U);
  MarkerTake leap = synthetic_take();
  for (std::size_t f = 300; f < 304; ++f) displace(leap, f, 5, 12);
  EXPECT_EQ(rejected_count(despike(leap)), 4U);
}

TEST(Despiker, RejectsAJumpBeforeItHasLearntAnything) {
  MarkerTake take = synthetic_take({.frames = 10});
  displace(take, 2, 5, 20);
  const auto judged = despike(take);
  EXPECT_EQ(judged[2].state[5], MarkerState::kRejected);
  EXPECT_EQ(judged[2].reason[5], RejectReason::kJump);
}

TEST(Despiker, RejectsAMarkerHoweverFarAndKeepsTheOthers) {
  for (const float far_mm : {3e2F, 3e3F, 1e5F, 999999.0F, 1e8F, 1e30F}) {
    for (const std::size_t from : {std::size_t{0}, std::size_t{300}}) {
      MarkerTake take = synthetic_take();
      for (std::size_t f = from; f < from + 5; ++f) {
        take.frames[f].position_mm[5] = {far_mm, -far_mm, far_mm};
      }
      const auto judged = despike(take);
      // What a take begins with is not doubted, unless no face is as large.
      if (from == 0 && far_mm < 4e3F) continue;
      for (std::size_t f = from; f < from + 5; ++f) EXPECT_EQ(judged[f].state[5], MarkerState::kRejected) << far_mm;
      EXPECT_EQ(rejected_count(judged), 5U) << far_mm << " from " << from;
    }
  }
}

TEST(Despiker, RecognisesAGhostAndASwap) {
  MarkerTake take = synthetic_take();
  take.frames[300].position_mm[5] = take.frames[300].position_mm[8];
  take.frames[300].position_mm[5].x += 0.3F;
  std::swap(take.frames[400].position_mm[5], take.frames[400].position_mm[8]);
  const auto judged = despike(take);
  EXPECT_EQ(judged[300].reason[5], RejectReason::kGhost);
  EXPECT_EQ(judged[300].state[8], MarkerState::kMeasured);
  EXPECT_EQ(judged[400].reason[5], RejectReason::kSwap);
  EXPECT_EQ(judged[400].reason[8], RejectReason::kSwap);
  EXPECT_EQ(rejected_count(judged), 3U);
}

TEST(Despiker, NeverChangesAPosition) {
  const test::Defects defects = test::make_defects(synthetic_take(), 5);
  MarkerTake take = synthetic_take();
  take.frames = defects.frames;
  const auto judged = despike(take);
  EXPECT_GT(rejected_count(judged), 0U);
  for (std::size_t f = 0; f < judged.size(); ++f) EXPECT_EQ(judged[f].position_mm, take.frames[f].position_mm);
}

TEST(Despiker, HeadMotionAloneRaisesNoAlarm) {
  // Faster than any head: 15 degrees at 1 Hz, 40 mm at 0.8 Hz, on a moving face.
  EXPECT_EQ(rejected_count(despike(synthetic_take({.head_moves = true}))), 0U);
}

TEST(Despiker, DisplacementMethodJudgesInTheWorld) {
  DespikerOptions options;
  options.method = DespikeMethod::kDisplacement;
  options.max_speed_mm_s = 250;
  MarkerTake take = synthetic_take();
  displace(take, 300, 5, 20);  // 1200 mm/s at 60 Hz
  const auto judged = despike(take, options);
  EXPECT_EQ(judged[300].reason[5], RejectReason::kJump);
  EXPECT_EQ(rejected_count(judged), 1U);
  EXPECT_GT(rejected_count(despike(synthetic_take({.head_moves = true}), options)), 0U);
}

TEST(Despiker, AcceptsARelabelledMarkerAfterTheDeclaredTime) {
  MarkerTake take = synthetic_take();
  for (std::size_t f = 300; f < 600; ++f) displace(take, f, 5, 30);
  const auto judged = despike(take);
  EXPECT_EQ(judged[300].state[5], MarkerState::kRejected);
  EXPECT_EQ(judged[328].state[5], MarkerState::kRejected);  // 29 frames = 0.483 s
  EXPECT_EQ(judged[332].state[5], MarkerState::kMeasured);  // 0.5 s is over
  EXPECT_EQ(judged[599].state[5], MarkerState::kMeasured);
}

TEST(Despiker, RejectsPositionsThatAreNotFinite) {
  for (const DespikeMethod method : {DespikeMethod::kDisplacement, DespikeMethod::kHeadFrame}) {
    MarkerTake take = synthetic_take({.frames = 20});
    take.frames[0].position_mm[1].x = std::numeric_limits<float>::quiet_NaN();
    take.frames[9].position_mm[2].y = -std::numeric_limits<float>::infinity();
    DespikerOptions options;
    options.method = method;
    Despiker despiker(options);
    despiker.use_marker_set(take.set);
    const auto judged = run_stage(despiker, take.frames);
    EXPECT_EQ(judged[0].reason[1], RejectReason::kNotFinite);
    EXPECT_EQ(judged[9].reason[2], RejectReason::kNotFinite);
    EXPECT_EQ(despiker.rejected(RejectReason::kNotFinite).value(), 2U);
  }
}

TEST(Despiker, SameInputTwiceGivesEqualBits) {
  MarkerTake take = synthetic_take();
  take.frames = test::make_defects(take, 3).frames;
  Despiker despiker;
  despiker.use_marker_set(take.set);
  const auto first = run_stage(despiker, take.frames);
  despiker.reset();
  const auto second = run_stage(despiker, take.frames);
  for (std::size_t f = 0; f < first.size(); ++f) ASSERT_TRUE(test::same_bits(first[f], second[f])) << f;
}

TEST(Despiker, AllocatesNothingPerFrame) {
  MarkerTake take = synthetic_take({.markers = 60, .frames = 150});
  take.frames = test::make_defects(take, 3).frames;
  Despiker despiker;
  despiker.use_marker_set(take.set);
  MarkerFrame out;
  const std::uint64_t before = test::allocations_of_this_thread();
  for (const MarkerFrame& frame : take.frames) {
    despiker.push(frame);
    despiker.pop(out);
  }
  despiker.flush();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(Despiker, KeepsJudgingMarkersThatRemainWhenTheSetChanges) {
  MarkerTake take = synthetic_take();
  Despiker despiker;
  despiker.use_marker_set(take.set);
  run_stage(despiker, {take.frames.begin(), take.frames.begin() + 300});
  MarkerTake fewer;
  fewer.set.names.assign(take.set.names.begin() + 4, take.set.names.end());
  fewer.frames.assign(1, take.frames[300]);
  fewer.frames[0].count = 20;
  std::copy(take.frames[300].position_mm.begin() + 4, take.frames[300].position_mm.begin() + 24,
            fewer.frames[0].position_mm.begin());
  displace(fewer, 0, 5, 20);
  despiker.use_marker_set(fewer.set);
  const auto judged = run_stage(despiker, fewer.frames);
  EXPECT_EQ(judged[0].state[5], MarkerState::kRejected);  // a despiker that had forgotten would have to believe it
  EXPECT_EQ(rejected_count(judged), 1U);
}

TEST(Despiker, RefusesAFrameOfAnotherCountAndKeepsItsBooks) {
  const MarkerTake take = synthetic_take({.frames = 2});
  Despiker despiker;
  despiker.use_marker_set(take.set);
  MarkerFrame odd = take.frames[0];
  odd.count = 300;
  MarkerFrame out;
  EXPECT_TRUE(despiker.push(odd));
  EXPECT_FALSE(despiker.pop(out));
  EXPECT_TRUE(despiker.push(take.frames[0]));
  EXPECT_FALSE(despiker.push(take.frames[1]));
  EXPECT_TRUE(despiker.pop(out));
  EXPECT_EQ(despiker.ledger().refused.value(), 1U);
  EXPECT_TRUE(despiker.ledger().balanced());
  EXPECT_EQ(despiker.ledger().held.value(), 0U);
}

TEST(Despiker, RejectsOptionsOutOfRange) {
  EXPECT_THROW(Despiker({.max_speed_mm_s = 0}), UserError);
  EXPECT_THROW(Despiker({.least_deviation_mm = 5, .most_deviation_mm = 4}), UserError);
  EXPECT_THROW(Despiker({.accept_after_ns = -1}), UserError);
}

// Recall by event on seeded defects: 99 %. False alarms: this guards twice the aim of 0.1 %, which is missed on one of
// the two takes (0.104 % on eyebrows, ./run bench repair).
TEST(Despiker, FindsSeededDefectsOnRealTakesWithFewFalseAlarms) {
  RISORIUS_NEEDS_DATA(folder, "animface");
  for (const char* name : {"jaw.csv", "eyebrows.csv"}) {
    MarkerTake take = test::read_marker_csv(folder / name, 60);
    const std::size_t samples = take.frames.size() * take.set.names.size();
    EXPECT_LE(static_cast<double>(rejected_count(despike(take))), 0.002 * static_cast<double>(samples)) << name;
    const test::Defects defects = test::make_defects(take, 1);
    take.frames = defects.frames;
    test::DespikeScore score;
    score.add(defects, despike(take));
    EXPECT_GE(static_cast<double>(score.found), 0.99 * static_cast<double>(score.events)) << name;
    EXPECT_LE(static_cast<double>(score.rejected_good), 0.002 * static_cast<double>(score.good_samples)) << name;
  }
}

}  // namespace
}  // namespace risorius
