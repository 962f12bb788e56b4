#include "capture/repair/take_rehearsal.h"

#include <gtest/gtest.h>
#include <random>

#include "support/synthetic_take.h"

namespace risorius {
namespace {

using test::MarkerTake;

struct Rehearsed {
  MarkerTake take;
  HeadTake heads;
  TakeRegression regression;
  TakeRehearsal rehearsal;

  Rehearsed(MarkerTake of, const std::vector<Gap>& gaps, std::size_t places)
      : take(std::move(of)),
        heads(carry_into_head_frame(take.frames, take.set, {})),
        regression(heads, take.set.names, nullptr),
        rehearsal(heads, regression) {
    for (const Gap& gap : gaps) rehearsal.practise(gap, regression.fill(gap).choice, places);
    rehearsal.conclude();
  }
};

const Gap kGap{3, 300, 330};

TEST(TakeRehearsal, BelievesTheRegressionBeforeAnythingWasRehearsed) {
  MarkerTake take = test::synthetic_take();
  test::hide(take, kGap.marker, kGap.begin, kGap.length());
  const Rehearsed none(take, {}, 0);
  const GapRegression::Fill said = none.regression.fill(kGap).fill;
  GapRegression::Fill believed = said;
  none.rehearsal.weigh(kGap, believed);
  EXPECT_LT((believed.position_mm - said.position_mm).norm(), 1e-9);
  // But for a quarter of the noise (0.05 mm), which is not sure to be only noise.
  EXPECT_LT((believed.variance_mm2 - said.variance_mm2).maxCoeff(), 0.5 * 0.05 * 0.05);
}

TEST(TakeRehearsal, AMarkerThatTremblesOnItsOwnHasAWiderIntervalThanTheRegressionThinks) {
  // The marker trembles, but not next to the gap, where the regression has most of its samples.
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1.5);
  MarkerTake take = test::synthetic_take();
  for (std::size_t f = 0; f < take.frames.size(); ++f) {
    if (f > 230 && f < 400) continue;
    take.frames[f].position_mm[kGap.marker].x += static_cast<float>(normal(random));
    take.frames[f].position_mm[kGap.marker].y += static_cast<float>(normal(random));
  }
  test::hide(take, kGap.marker, kGap.begin, kGap.length());
  const Rehearsed rehearsed(take, {kGap}, 30);
  GapRegression::Fill fill = rehearsed.regression.fill(kGap).fill;
  const double stated = fill.variance_mm2.mean();
  rehearsed.rehearsal.weigh(kGap, fill);
  EXPECT_GT(fill.variance_mm2.mean(), 1.3 * stated);  // measured 1.42
}

TEST(TakeRehearsal, NeedsAPlaceWhereTheMarkerIsSeenLongEnough) {
  MarkerTake take = test::synthetic_take({.frames = 200});
  for (std::size_t f = 0; f < 200; f += 20) test::hide(take, 3, f, 10);
  const Gap longer{3, 100, 112};
  const Rehearsed rehearsed(take, {longer}, 8);  // nowhere: nothing to learn, nothing to break
  GapRegression::Fill fill = rehearsed.regression.fill(longer).fill;
  const GapRegression::Fill said = fill;
  rehearsed.rehearsal.weigh(longer, fill);
  EXPECT_LT((fill.position_mm - said.position_mm).norm(), 1e-9);
}

}  // namespace
}  // namespace risorius
