#include "replay/pipeline/neutral_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/offline_pipeline.h"
#include "replay/pipeline/rig_neutral.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

/// Without occlusions and false tracks.
PerformerOptions options_of(ScriptKind script, double seconds) {
  return {.seed = 3, .rate_hz = 60, .seconds = seconds, .occlusion_share = 0, .false_track_share = 0, .script = script};
}

/// A performed take with the true intensities of its frames.
struct Performed {
  std::vector<MarkerFrame> frames;
  std::vector<double> largest;  // of the AUs of a frame, lids left out: people blink at rest
};

Performed perform(ScriptKind script, double seconds) {
  PerformerTake take(builtin_rig(), options_of(script, seconds));
  const auto names = take.performance().rig().au_names();
  Performed result;
  MarkerFrame frame;
  while (take.next(frame)) {
    double largest = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!names[i].starts_with("AU45") && !names[i].starts_with("AU7")) {
        largest = std::max(largest, take.truth().intensity[i]);
      }
    }
    result.largest.push_back(largest);
  }
  take.rewind();
  result.frames = read_despiked(take, {});
  return result;
}

TEST(NeutralCandidates, TheBestIsWhereThePerformersFaceIsAtRest) {
  // In a range of motion people come back to rest between any two actions.
  const Performed take = perform(ScriptKind::kRom, 40);
  const auto found = neutral_candidates(take.frames);
  ASSERT_FALSE(found.empty());
  double largest = 0;
  for (auto t = found[0].first; t <= found[0].last; ++t) largest = std::max(largest, take.largest[t]);
  EXPECT_LT(largest, 0.25);  // measured 0.08: micro-motion; actions of this script reach 1
  EXPECT_GT(*std::ranges::max_element(take.largest), 0.6);
}

TEST(NeutralCandidates, AStretchThatNeverSeesAMarkerComesAfterOneThatSeesAll) {
  Performed take = perform(ScriptKind::kRom, 40);
  const auto all_seen = neutral_candidates(take.frames);
  ASSERT_GE(all_seen.size(), 2u);
  for (auto t = all_seen[0].first; t <= all_seen[0].last; ++t) take.frames[t].state[7] = MarkerState::kMissing;
  const auto found = neutral_candidates(take.frames);
  ASSERT_FALSE(found.empty());
  const auto is_seen = [&](std::uint64_t t) { return take.frames[t].state[7] == MarkerState::kMeasured; };
  bool seen = false;
  for (auto t = found[0].first; t <= found[0].last; ++t) seen |= is_seen(t);
  EXPECT_TRUE(seen);
  // One that is never seen anywhere decides nothing.
  for (MarkerFrame& frame : take.frames) frame.state[7] = MarkerState::kMissing;
  const auto without = neutral_candidates(take.frames);
  ASSERT_FALSE(without.empty());
  EXPECT_GT(without[0].score, 0.5 * all_seen[0].score);
}

TEST(NeutralCandidates, FlickeringMarkersHideNoRest) {
  // Every marker is lost for a third of each half second, each at another time: no window sees one throughout.
  Performed take = perform(ScriptKind::kRom, 40);
  for (std::size_t t = 0; t < take.frames.size(); ++t) {
    MarkerFrame& frame = take.frames[t];
    for (std::size_t m = 0; m < frame.count; ++m) {
      if ((t + 7 * m) % 30 < 10 || t % 5 == 0) frame.state[m] = MarkerState::kMissing;  // and whole frames
    }
  }
  const auto found = neutral_candidates(take.frames);
  ASSERT_FALSE(found.empty());
  double largest = 0;
  for (auto t = found[0].first; t <= found[0].last; ++t) largest = std::max(largest, take.largest[t]);
  EXPECT_LT(largest, 0.25);  // as with all markers
}

TEST(NeutralCandidates, AMarkerThatTheTakeHardlyHasDecidesNothing) {
  // A third of the names are of markers that were never there.
  Performed take = perform(ScriptKind::kRom, 40);
  for (MarkerFrame& frame : take.frames) {
    for (std::size_t m = 0; m < frame.count; m += 3) frame.state[m] = MarkerState::kMissing;
  }
  const auto found = neutral_candidates(take.frames);
  ASSERT_FALSE(found.empty());
  double largest = 0;
  for (auto t = found[0].first; t <= found[0].last; ++t) largest = std::max(largest, take.largest[t]);
  EXPECT_LT(largest, 0.25);
}

TEST(NeutralCandidates, AreOrderedAndDoNotOverlap) {
  const Performed take = perform(ScriptKind::kRom, 30);
  const auto found = neutral_candidates(take.frames);
  ASSERT_GE(found.size(), 2u);
  for (std::size_t k = 1; k < found.size(); ++k) {
    EXPECT_LE(found[k].score, found[k - 1].score);
    for (std::size_t other = 0; other < k; ++other) {
      EXPECT_TRUE(found[k].last < found[other].first || found[k].first > found[other].last);
    }
  }
  EXPECT_LT(found[0].last, take.frames.size());
}

TEST(NeutralCandidates, FindsNoneWhereNoMarkersAreSeen) {
  Performed take = perform(ScriptKind::kIdle, 3);
  for (MarkerFrame& frame : take.frames) frame.state.fill(MarkerState::kMissing);
  EXPECT_TRUE(neutral_candidates(take.frames).empty());
  EXPECT_TRUE(neutral_candidates({}).empty());
}

TEST(RigNeutral, LaysTheSessionsNeutralOnTheRig) {
  const Rig rig = builtin_rig();
  Neutral neutral{.marker_names = rig.marker_names, .position_mm = rig.neutral_mm};
  neutral.position_mm.col(10).y() += 2;  // glued 2 mm higher
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitY());
  for (Eigen::Index m = 0; m < neutral.position_mm.cols(); ++m) {
    neutral.position_mm.col(m) = turn * neutral.position_mm.col(m) + Eigen::Vector3d(100, 20, -5);
  }
  const RenewedRig renewed = with_neutral(rig, neutral, "take:0-9");
  EXPECT_EQ(renewed.moved_most_marker, rig.marker_names[10]);
  EXPECT_NEAR(renewed.moved_most_mm, 2, 0.05);
  EXPECT_NEAR((renewed.rig.neutral_mm.col(10) - rig.neutral_mm.col(10)).y(), 2, 0.05);
  EXPECT_EQ(renewed.rig.aus[0].displacement_mm, rig.aus[0].displacement_mm);
}

TEST(RigNeutral, RefusesAnotherFaceAndAnotherLayout) {
  const Rig rig = builtin_rig();
  Neutral neutral{.marker_names = rig.marker_names, .position_mm = 3 * rig.neutral_mm};
  EXPECT_THROW(with_neutral(rig, neutral, "take"), UserError);
  for (std::string& name : neutral.marker_names) name = "other" + name;
  EXPECT_THROW(with_neutral(rig, neutral, "take"), UserError);
}

TEST(RigNeutral, RefusesAMovingFaceAndFindsAStillOne) {
  PerformerTake take(builtin_rig(), options_of(ScriptKind::kRom, 40));
  const ChosenNeutral chosen = read_neutral(take, parse_neutral_place("builtin:auto"));
  EXPECT_LT(chosen.neutral.motion_rms_mm, 1);
  EXPECT_TRUE(chosen.place.starts_with("builtin:"));
  // A face that swings by 10 mm.
  class Swinging : public TakeReader {
   public:
    explicit Swinging(TakeReader& take) : take_(take) {}
    const TakeInfo& info() const noexcept override { return take_.info(); }
    bool next(MarkerFrame& frame) override {
      if (!take_.next(frame)) return false;
      for (std::size_t m = 0; m < frame.count / 2; ++m) frame.position_mm[m].y += ++count_ % 100 < 50 ? 10.F : -10.F;
      return true;
    }
    void rewind() override { take_.rewind(); }

   private:
    TakeReader& take_;
    int count_ = 0;
  } swinging(take);
  EXPECT_THROW(read_neutral(swinging, parse_neutral_place("builtin:0-300")), UserError);
}

}  // namespace
}  // namespace risorius
