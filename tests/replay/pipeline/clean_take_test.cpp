#include "replay/pipeline/clean_take.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "capture/repair/offline_repair.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/frame_pipeline.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/rig_fit.h"
#include "solve/rigs/rig_motion.h"
#include "support/synthetic_take.h"

namespace risorius {
namespace {

PerformerTake performance() { return PerformerTake(builtin_rig(), {.seconds = 5, .regions_per_minute = 12}); }

TEST(CleanTake, CausallyGivesTheBitsOfTheLiveService) {
  PerformerTake take = performance();
  const CleanedTake cleaned = clean_take(take, {.is_causal = true, .known_motion = motion_of(builtin_rig())});
  take.rewind();
  FramePipeline live({}, builtin_rig());
  live.use_marker_set(take.info().markers);
  SolvedFrame solved;
  std::size_t f = 0;
  for (MarkerFrame frame; take.next(frame);) {
    ASSERT_TRUE(live.push(frame));
    while (live.pop(solved)) ASSERT_TRUE(test::same_bits(solved.markers, cleaned.after.at(f++)));
  }
  EXPECT_EQ(f, cleaned.after.size());
}

/// Somebody else than the built-in face; the mouth's markers are seen for a third of a second, before they move, and
/// then hidden.
struct HiddenMouth {
  std::vector<MarkerFrame> truth;
  MarkerSet set;
  std::shared_ptr<const KnownMotion> rig;

  HiddenMouth() {
    PerformerTake take(builtin_rig(), {.seed = 3,
                                       .seconds = 12,
                                       .noise_mm = 0.05,
                                       .occlusion_share = 0,
                                       .false_track_share = 0,
                                       .head_motion = 0,
                                       .perturb = PerturbOptions::like_people()});
    set = take.info().markers;
    for (MarkerFrame frame; take.next(frame);) truth.push_back(frame);
    const Rig& actor = take.performance().true_rig();
    rig =
        motion_of(fit_rig(builtin_face(), actor.marker_names, actor.neutral_mm, find_landmark_map(kBuiltinLayout)).rig);
  }
  bool hides(std::size_t i) const { return set.names[i].starts_with("Mou"); }
};

TEST(CleanTake, TheRigSaysHowMarkersMoveThatWereHardlySeen) {
  const HiddenMouth mouth;
  const auto mean_error_mm = [&](bool is_causal, const std::shared_ptr<const KnownMotion>& known) {
    std::vector<MarkerFrame> frames = mouth.truth;
    for (std::size_t f = 20; f < frames.size(); ++f) {
      for (std::size_t i = 0; i < frames[f].count; ++i) {
        if (mouth.hides(i)) frames[f].state[i] = MarkerState::kMissing;
      }
    }
    if (is_causal) {
      GapFiller filler({.max_gap_ns = 60'000'000'000, .known_motion = known});
      filler.use_marker_set(mouth.set);
      frames = test::run_stage(filler, frames);
    } else {
      fill_offline(frames, mouth.set, {.max_gap_ns = 60'000'000'000, .known_motion = known});
    }
    double sum = 0, samples = 0;
    for (std::size_t f = 20; f < frames.size(); ++f) {
      for (std::size_t i = 0; i < frames[f].count; ++i) {
        if (!mouth.hides(i)) continue;
        EXPECT_EQ(frames[f].state[i], MarkerState::kFilled);
        if (test::distance_mm(mouth.truth[19].position_mm[i], mouth.truth[f].position_mm[i]) < 3) continue;
        sum += test::distance_mm(frames[f].position_mm[i], mouth.truth[f].position_mm[i]);
        ++samples;
      }
    }
    return sum / samples;
  };
  for (const bool is_causal : {false, true}) {
    const double told = mean_error_mm(is_causal, mouth.rig), untold = mean_error_mm(is_causal, nullptr);
    EXPECT_LT(told, 0.8 * untold) << is_causal;  // measured .72 and .53
  }
}

TEST(CleanTake, HoldsTheHeadStillAndNamesTheMarkersThatWereRepairedMost) {
  test::MarkerTake take = test::synthetic_take({.head_moves = true});
  test::hide(take, 7, 100, 60);
  test::hide(take, 3, 200, 30);
  test::hide(take, 9, 0, take.frames.size());
  CleanedTake cleaned{.before = take.frames, .after = take.frames};
  fill_offline(cleaned.after, take.set, {});
  EXPECT_EQ(most_repaired(cleaned, take.set, 2), (std::vector<std::string>{"M7", "M3"}));
  hold_head_still(cleaned, take.set);
  const auto travelled_mm = [](const std::vector<MarkerFrame>& frames, std::size_t i) {
    double farthest = 0;
    for (const MarkerFrame& f : frames) {
      farthest = std::max(farthest, test::distance_mm(f.position_mm[i], frames[0].position_mm[i]));
    }
    return farthest;
  };
  EXPECT_GT(travelled_mm(take.frames, 23), 40);   // with the head
  EXPECT_LT(travelled_mm(cleaned.after, 23), 3);  // the upper half hardly moves on it
  EXPECT_LT(travelled_mm(cleaned.before, 23), 3);
}

TEST(CleanTake, CountsEverySampleOnce) {
  PerformerTake take = performance();
  for (const CleanOptions& options : {CleanOptions{}, CleanOptions{.is_causal = true, .lookahead_frames = 5},
                                      CleanOptions{.baseline = "linear_head"}}) {
    take.rewind();
    const CleanedTake cleaned = clean_take(take, options);
    ASSERT_EQ(cleaned.after.size(), cleaned.before.size());
    std::uint64_t rejected = 0;
    for (std::size_t r = 1; r < cleaned.rejected.size(); ++r) rejected += cleaned.rejected[r];
    const std::uint64_t samples = cleaned.before.size() * cleaned.before.front().count;
    EXPECT_EQ(cleaned.measured + cleaned.filled + cleaned.left_missing, samples);
    EXPECT_EQ(cleaned.measured + cleaned.missing + rejected, samples);
    EXPECT_GT(rejected, 0U);
    EXPECT_GT(cleaned.filled, cleaned.left_missing);
  }
}

TEST(CleanTake, RefusesOptionsThatContradictEachOther) {
  PerformerTake take = performance();
  EXPECT_THROW(clean_take(take, {.lookahead_frames = 5}), UserError);
  EXPECT_THROW(clean_take(take, {.is_causal = true, .baseline = "pca"}), UserError);
  EXPECT_THROW(clean_take(take, {.baseline = "spline"}), UserError);
}

}  // namespace
}  // namespace risorius
