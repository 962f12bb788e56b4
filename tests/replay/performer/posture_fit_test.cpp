#include "replay/performer/posture_fit.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "replay/performer/au_moves.h"
#include "replay/performer/random.h"
#include "replay/performer/wander_fit.h"

namespace {

using namespace risorius;

/// AU1 acts every 4 s for 2 s; AU12 with it, `lag_s` later and `slower` times as slowly.
PreparedSeries two_that_act_together(double lag_s, double slower) {
  PreparedSeries series{{"AU1", "AU12L", "AU12R"}, 30, {}, {}};
  std::vector<AuMove> moves;
  for (int i = 0; i < 20; ++i) {
    const double begin_s = 2 + 4 * i, sign = i % 2 == 0 ? 1 : -1;
    for (const std::uint32_t au : {0u, 1u, 2u}) {
      const double late = au == 0 ? 0 : sign * lag_s, way_s = au == 0 ? 0.4 : 0.4 * slower;
      moves.push_back({au, begin_s + late, way_s, 0.6, 1});
      moves.push_back({au, begin_s + late + 2, way_s, -0.6, 1});
    }
  }
  AuMoveTrack track(moves, 3);
  for (int f = 0; f < 30 * 84; ++f) {
    track.values_at(f / 30.0, series.rows.emplace_back(3));
    series.rest.emplace_back(3);
  }
  return series;
}

TEST(PostureFit, FindsLagAndPaceOfWhatActsTogether) {
  const PreparedSeries late = two_that_act_together(0.1, 1);
  const Timing lagging = fit_timing(late, find_actions(late));
  EXPECT_NEAR(lagging.lag_s, 0.1 / std::numbers::sqrt2, 0.005);
  EXPECT_NEAR(lagging.pace, 0, 0.05);
  EXPECT_EQ(lagging.split_probability, 0) << "one step each";
  EXPECT_NEAR(lagging.shifts_per_second, 0, 0.01) << "held still";
  const PreparedSeries slow = two_that_act_together(0, 1.4);
  EXPECT_NEAR(fit_timing(slow, find_actions(slow)).pace, std::log(1.4) / std::numbers::sqrt2, 0.06);
}

TEST(PostureFit, FindsWhatGoesTogether) {
  const PostureTable table = fit_postures(two_that_act_together(0, 1));
  ASSERT_EQ(table.aus, (std::vector<std::string>{"AU1", "AU12"})) << "sides are one";
  EXPECT_NEAR(table.correlation(0, 1), 0.9, 0.01) << "all of it, less the shrinking";
  EXPECT_NEAR(table.levels[0].back(), 0.6, 1e-9);
  EXPECT_NEAR(table.levels[0][3], 0.0, 1e-6) << "it rests for more than a third of the time";
}

TEST(PostureFit, MemoryIsTheRanksAutocorrelation) {
  PreparedSeries series{{"AU1"}, 30, {}, {}};
  Random random(2, 2);
  double x = 0;
  const double kept = std::exp(-1 / 30.0);  // forgets in a second
  for (int f = 0; f < 30 * 3000; ++f) {
    x = kept * x + std::sqrt(1 - kept * kept) * random.gaussian();
    series.rows.push_back({x});
  }
  const auto rank = [](double r) { return 6 / std::numbers::pi * std::asin(r / 2); };
  EXPECT_NEAR(posture_memory(series, 0.5), rank(std::exp(-0.5)), 0.02);
  EXPECT_NEAR(posture_memory(series, 2), rank(std::exp(-2)), 0.04);
}

TEST(RestSpectrum, OfWhiteNoiseIsFlatAndHoldsItsVariance) {
  PreparedSeries series{{"AU1"}, 30, {}, {}};
  Random random(1, 1);
  constexpr double kDeviation = 0.005;
  for (int f = 0; f < 30 * 600; ++f) series.rows.push_back({0.03 + kDeviation * random.gaussian()});
  const RestSpectrum spectrum = rest_spectrum(series, 60);
  ASSERT_EQ(spectrum.density.size(), 60u);
  EXPECT_NEAR(spectrum.frequency_hz.back(), 15, 1e-9);
  // One-sided: variance over 15 Hz. 299 half-overlapping windows scatter by about 7 %.
  for (std::size_t i = 1; i + 1 < 60; ++i)
    EXPECT_NEAR(spectrum.density[i] / (kDeviation * kDeviation / 15), 1, 0.3) << spectrum.frequency_hz[i];
  series.rows.assign(30 * 60, {0.5});
  EXPECT_TRUE(rest_spectrum(series, 60).density.empty()) << "it does not rest";
}

}  // namespace
