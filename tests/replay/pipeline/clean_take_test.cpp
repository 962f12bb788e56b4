#include "replay/pipeline/clean_take.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/frame_pipeline.h"
#include "solve/faces/builtin_face.h"
#include "support/synthetic_take.h"

namespace risorius {
namespace {

PerformerTake performance() { return PerformerTake(builtin_rig(), {.seconds = 5, .regions_per_minute = 12}); }

TEST(CleanTake, CausallyGivesTheBitsOfTheLiveService) {
  PerformerTake take = performance();
  const CleanedTake cleaned = clean_take(take, {.is_causal = true});
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
