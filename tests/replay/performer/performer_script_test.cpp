#include "replay/performer/performer_script.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

namespace {

using namespace risorius;

TEST(AuPulse, RisesHoldsAndFallsSmoothly) {
  const AuPulse pulse{0, 2, 0.5, 1, 0.8, 0.9};
  EXPECT_EQ(pulse.value_at(1.9), 0);
  EXPECT_EQ(pulse.value_at(2), 0);
  EXPECT_NEAR(pulse.value_at(2.25), 0.45, 1e-12);  // a minimum-jerk curve is half way at half time
  EXPECT_EQ(pulse.value_at(2.5), 0.9);
  EXPECT_EQ(pulse.value_at(3.2), 0.9);
  EXPECT_NEAR(pulse.value_at(3.9), 0.45, 1e-12);
  EXPECT_EQ(pulse.value_at(4.4), 0);
  for (double t = 1.9; t < 4.5; t += 1e-3) {
    const double acceleration = (pulse.value_at(t + 1e-3) - 2 * pulse.value_at(t) + pulse.value_at(t - 1e-3)) / 1e-6;
    // Minimum jerk: at most 5.77 peak / duration^2 (Flash & Hogan), here 20.8 on the onset.
    EXPECT_LT(std::abs(acceleration), 21) << t;
  }
}

TEST(PerformerScript, PlaysOnlyAusThatTheRigHas) {
  const std::vector<std::string> names{"AU12L", "AU12R", "AU27", "mouthLeft", "AU1", "AU10L"};
  const PerformerScript script(names, 120, 3);
  std::set<std::uint32_t> seen;
  for (const AuPulse& pulse : script.pulses()) {
    ASSERT_LT(pulse.au, names.size());
    seen.insert(pulse.au);
    EXPECT_GE(pulse.peak, 0);
    EXPECT_LE(pulse.peak, 1);
  }
  EXPECT_EQ(seen.size(), names.size());  // single actions reach every column
  EXPECT_TRUE(PerformerScript({}, 10, 1).pulses().empty());
}

TEST(PerformerScript, TheJawGoesToOneSideAtATime) {
  const PerformerScript script({"AU30L", "AU30R"}, 300, 2);
  const std::vector<AuPulse>& pulses = script.pulses();
  ASSERT_GT(pulses.size(), 10u);
  for (std::size_t i = 0; i + 1 < pulses.size(); ++i) EXPECT_GT(pulses[i + 1].begin_s, pulses[i].end_s());
}

TEST(PerformerScript, AU1IsNotAU12) {
  // "sad" moves AU1 but not AU12: with these two columns a rule that goes by prefix would move both together.
  const PerformerScript script({"AU1", "AU12"}, 200, 4);
  std::size_t together = 0, alone = 0;
  for (const AuPulse& pulse : script.pulses()) {
    const bool has_twin = std::any_of(script.pulses().begin(), script.pulses().end(), [&](const AuPulse& other) {
      return other.au != pulse.au && std::abs(other.begin_s - pulse.begin_s) < 0.1;
    });
    ++(has_twin ? together : alone);
  }
  EXPECT_EQ(together, 0u);
  EXPECT_GT(alone, 20u);
}

TEST(PerformerScript, BeginsNeutralAndFollowsItsPulses) {
  PerformerScript script({"AU6L", "AU6R", "AU12L", "AU12R"}, 60, 5);
  std::vector<double> x(4, 1);
  script.intensities_at(0.5, x);
  EXPECT_EQ(x, std::vector<double>(4, 0));
  for (double t = 0; t < 60; t += 0.01) {
    script.intensities_at(t, x);
    std::vector<double> rest(4, 1);
    for (const AuPulse& pulse : script.pulses()) rest[pulse.au] *= 1 - pulse.value_at(t);
    for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(x[k], 1 - rest[k], 1e-12) << t;
  }
}

TEST(PerformerScript, SidesAreAlikeButNotEqual) {
  const PerformerScript script({"AU12L", "AU12R"}, 300, 6);
  double largest_difference = 0;
  for (std::size_t i = 0; i + 1 < script.pulses().size(); ++i) {
    const AuPulse &a = script.pulses()[i], &b = script.pulses()[i + 1];
    if (a.begin_s != b.begin_s) continue;
    largest_difference = std::max(largest_difference, std::abs(a.peak - b.peak));
  }
  EXPECT_GT(largest_difference, 0.05);
  EXPECT_LE(largest_difference, 0.3 + 1e-12);  // 1 +- 0.15
}

}  // namespace
