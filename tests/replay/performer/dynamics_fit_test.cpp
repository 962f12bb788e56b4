#include "replay/performer/dynamics_fit.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "capture/errors.h"
#include "replay/performer/au_moves.h"
#include "replay/performer/au_wander.h"

namespace {

using namespace risorius;

/// Actions of one AU at known times: onset 0.4 s, apex 1 s, offset 0.6 s, every 5 s, over a resting level.
AuSeries known_actions(double rest) {
  AuSeries series{{"AU12L", "AU45L"}, {}, {}};
  std::vector<AuMove> moves;
  for (int i = 0; i < 10; ++i) {
    const double begin_s = 2 + 5 * i;
    moves.push_back({0, begin_s, 0.4, 0.8, 1});
    moves.push_back({0, begin_s + 1.4, 0.6, -0.8, 1});
  }
  AuMoveTrack track(moves, 2);
  for (std::uint64_t f = 0; f < 60 * 55; ++f) {
    auto& row = series.intensities.emplace_back(2);
    track.values_at(static_cast<double>(f) / 60, row);
    row[0] += rest;
    row[1] = 0.9;
    series.frames.push_back(f);
  }
  return series;
}

TEST(ActionStatistics, MeasuresKnownActionsOverAnUncalibratedRest) {
  const PreparedSeries prepared = prepare_series(known_actions(0.2), 60);
  EXPECT_EQ(prepared.names, std::vector<std::string>{"AU12L"}) << "lids follow the gaze and are left out";
  const auto actions = find_actions(prepared);
  ASSERT_EQ(actions.size(), 10u);
  for (const AuAction& action : actions) {
    EXPECT_NEAR(action.peak, 0.8, 0.01);
    // Minimum jerk: 1.875 peak / duration; three samples at 30 Hz and a central difference take off the top.
    EXPECT_NEAR(action.peak_velocity, 1.875 * 0.8 / 0.4, 0.35);
    EXPECT_NEAR(action.onset_s, 0.4, 0.15);
    EXPECT_NEAR(action.offset_s, 0.6, 0.15);
    EXPECT_NEAR(action.hold_s, 1.25, 0.15);  // the apex, and the last tenths of both ways
  }
  const ActionDistributions d = distributions_of(actions);
  ASSERT_EQ(d.rest_to_rest_s.size(), 9u);
  for (const double interval : d.rest_to_rest_s) EXPECT_NEAR(interval, 5, 0.04);
  EXPECT_TRUE(find_actions(part_of(prepared, 0, 100)).empty()) << "cut by the end";
}

TEST(ActionStatistics, QuantilesInterpolate) {
  EXPECT_EQ(quantile_of({4, 1, 3, 2}, 0), 1);
  EXPECT_EQ(quantile_of({4, 1, 3, 2}, 1), 4);
  EXPECT_EQ(quantile_of({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_EQ(quantile_of({}, 0.5), 0);
}

TEST(AuWander, HasTheAskedDeviationAndMemory) {
  constexpr double kRate = 60, kDeviation = 0.02, kTime = 0.2;
  AuWander wander(4, {kDeviation, kTime}, {0, 1}, 1, kRate, 3);
  const std::vector<double> upper(4, 1);
  double squares = 0, products = 0;
  std::vector<double> last(4, 0);
  constexpr int kFrames = 60 * 300, kLag = 12;  // 0.2 s
  std::vector<std::vector<double>> rows;
  for (int f = 0; f < kFrames; ++f) {
    auto& row = rows.emplace_back(4, 0.5);
    wander.add_to(row, upper);
  }
  for (int f = 600; f + kLag < kFrames; ++f) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double a = rows[static_cast<std::size_t>(f)][k] - 0.5,
                   b = rows[static_cast<std::size_t>(f + kLag)][k] - 0.5;
      squares += a * a;
      products += a * b;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / (4.0 * (kFrames - 600 - kLag))), kDeviation, 0.1 * kDeviation);
  EXPECT_NEAR(products / squares, 2 * std::exp(-1.0), 0.06);  // (1 + t / T) exp(-t / T)
}

TEST(DynamicsFit, FindsItsOwnPerformanceAgain) {
  Dynamics truth = shipped_dynamics();
  truth.onset_s.median *= 1.3;
  truth.hold_s.median *= 0.6;
  const std::vector<std::string> names{"AU1",   "AU4L",  "AU4R", "AU10L", "AU10R",
                                       "AU12L", "AU12R", "AU17", "AU18",  "AU27"};
  const PreparedSeries recorded = prepare_series(perform_range_of_motion(names, truth, 400, 5), 30);
  const Dynamics fitted = fit_dynamics(recorded, {.seed = 9, .rounds = 12, .takes = 1});
  const auto real = distributions_of(find_actions(recorded));
  const auto made = distributions_of(find_actions(prepare_series(perform_range_of_motion(names, fitted, 400, 77), 30)));
  for (const double share : {0.5, 0.9}) {
    EXPECT_NEAR(quantile_of(made.peak_velocity, share) / quantile_of(real.peak_velocity, share), 1, 0.25) << share;
    EXPECT_NEAR(quantile_of(made.duration_s, share) / quantile_of(real.duration_s, share), 1, 0.25) << share;
    EXPECT_NEAR(quantile_of(made.rest_to_rest_s, share) / quantile_of(real.rest_to_rest_s, share), 1, 0.3) << share;
  }
  EXPECT_THROW(fit_dynamics(part_of(recorded, 0, 60)), std::invalid_argument);
}

TEST(Dynamics, JsonGivesTheSameTableBack) {
  const std::string json = dynamics_to_json(shipped_dynamics());
  EXPECT_EQ(dynamics_to_json(parse_dynamics(json, "copy")), json);
  EXPECT_FALSE(shipped_dynamics().source.empty());
  EXPECT_NE(shipped_dynamics().licence.find("MIT"), std::string::npos);
}

TEST(Dynamics, RefusesBrokenTablesByTheirField) {
  const auto complaint = [](std::string json, const std::string& from, const std::string& to) -> std::string {
    json.replace(json.find(from), from.size(), to);
    try {
      parse_dynamics(json, "my.json");
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  const std::string json = dynamics_to_json(shipped_dynamics());
  EXPECT_NE(complaint(json, "\"version\": 2", "\"version\": 7").find("version 7"), std::string::npos);
  EXPECT_NE(complaint(json, "\"hold_s\"", "\"held_s\"").find("hold_s.median"), std::string::npos);
  EXPECT_NE(complaint(json, "\"onset_skew\": ", "\"onset_skew\": 9").find("onset_skew"), std::string::npos);
  EXPECT_NE(complaint(json, "\"lag_s\"", "\"lags\"").find("timing.lag_s"), std::string::npos);
  EXPECT_NE(complaint(json, "\"levels\": {", "\"levels\": {\"AU99\": [0.5],").find("levels.AU99"), std::string::npos);
  EXPECT_NE(complaint(json, "\"correlation\": {", "\"correlations\": {").find("postures.correlation"),
            std::string::npos);
  EXPECT_THROW(parse_dynamics("{}", "my.json"), UserError);
}

}  // namespace
