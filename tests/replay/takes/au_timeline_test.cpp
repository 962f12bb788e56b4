#include "replay/takes/au_timeline.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace risorius;

TEST(AuTimeline, PassesThroughItsSamplesAndNeverBeyondThem) {
  AuSeries series{{"AU12L"}, {}, {}};
  for (std::uint64_t f = 0; f < 200; ++f) {
    series.frames.push_back(f);
    series.intensities.push_back({0.5 + 0.5 * std::sin(0.4 * static_cast<double>(f * f % 97))});
  }
  const AuTimeline timeline(series, 30, {"AU12L"});
  double value = 0;
  for (std::size_t f = 0; f + 1 < 200; ++f) {
    timeline.at(static_cast<double>(f) / 30, {&value, 1});
    EXPECT_NEAR(value, series.intensities[f][0], 1e-9);
    const auto [low, high] = std::minmax(series.intensities[f][0], series.intensities[f + 1][0]);
    for (double u = 0.1; u < 1; u += 0.2) {
      timeline.at((static_cast<double>(f) + u) / 30, {&value, 1});
      EXPECT_GE(value, low - 1e-9);
      EXPECT_LE(value, high + 1e-9);
    }
  }
  EXPECT_NEAR(timeline.seconds(), 199.0 / 30, 1e-12);
}

TEST(AuTimeline, BridgesGapsHoldsEndsAndSaysWhatIsMissing) {
  const double none = std::nan("");
  const AuSeries series{
      {"AU1", "AU9L", "AU9R", "gaze"}, {10, 11, 15}, {{none, 0.2, 0.4, 1}, {0.1, 0.2, 0.4, 1}, {0.5, 0.2, 0.4, 1}}};
  const AuTimeline timeline(series, 10, {"AU1R", "AU9", "AU12L"});
  EXPECT_EQ(timeline.masked(), std::vector<std::string>{"AU12L"});
  EXPECT_EQ(timeline.unused(), std::vector<std::string>{"gaze"});
  std::vector<double> x(3);
  timeline.at(-1, x);
  EXPECT_NEAR(x[0], 0.1, 1e-12);
  EXPECT_NEAR(x[1], 0.3, 1e-12);  // the mean of the sides
  EXPECT_EQ(x[2], 0);
  timeline.at(0.3, x);
  EXPECT_NEAR(x[0], 0.3, 1e-9);  // half way from frame 11 to 15
  timeline.at(9, x);
  EXPECT_NEAR(x[0], 0.5, 1e-12);
  EXPECT_THROW(AuTimeline(AuSeries{}, 30, {"AU1"}), std::invalid_argument);
  EXPECT_THROW(AuTimeline(series, 0, {"AU1"}), std::invalid_argument);
}

}  // namespace
