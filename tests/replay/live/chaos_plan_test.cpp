#include "replay/live/chaos_plan.h"

#include <gtest/gtest.h>
#include <vector>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::int64_t kStepNs = 4'000'000;

std::vector<ChaosDecision> decisions(const ChaosOptions& options, int count = 20'000) {
  ChaosPlan plan(options);
  std::vector<ChaosDecision> made;
  for (int i = 0; i < count; ++i) made.push_back(plan.decide(1000, i * kStepNs));
  return made;
}

bool same(const ChaosCopy& a, const ChaosCopy& b) {
  return a.turned_bit == b.turned_bit && a.held_back == b.held_back && a.delay_ns == b.delay_ns;
}

bool same(const ChaosDecision& a, const ChaosDecision& b) {
  return a.fate == b.fate && a.copies == b.copies && same(a.copy[0], b.copy[0]) && same(a.copy[1], b.copy[1]);
}

const ChaosOptions kAll{.loss = 0.1,
                        .reorder = 0.05,
                        .duplicate = 0.05,
                        .corrupt = 0.01,
                        .burst_ns = 100'000'000,
                        .burst_interval_ns = 2'000'000'000,
                        .delay_ns = 1'000'000,
                        .jitter_ns = 2'000'000,
                        .seed = 5};

TEST(ChaosPlan, SameSeedMakesTheSameDecisionsAndAnotherSeedOthers) {
  const auto first = decisions(kAll), again = decisions(kAll);
  ChaosOptions other_options = kAll;
  other_options.seed = 6;
  const auto other = decisions(other_options);
  std::size_t different = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_TRUE(same(first[i], again[i])) << i;
    different += same(first[i], other[i]) ? 0 : 1;
  }
  EXPECT_GT(different, first.size() / 2);  // the jitter alone makes nearly all of them differ
}

TEST(ChaosPlan, FaultsHaveTheirProbability) {
  const auto made = decisions({.loss = 0.1, .reorder = 0.05, .duplicate = 0.2, .corrupt = 0.01});
  double lost = 0, twice = 0, held = 0, corrupt = 0;
  for (const auto& decision : made) {
    lost += decision.fate == ChaosFate::kLost ? 1 : 0;
    twice += decision.copies == 2 ? 1 : 0;
    held += decision.copy[0].held_back > 0 ? 1 : 0;
    corrupt += decision.copy[0].turned_bit ? 1 : 0;
    EXPECT_LT(decision.copy[0].turned_bit.value_or(0), 8000u);
    EXPECT_LE(decision.copy[0].held_back, ChaosPlan::kMostHeldBack);
    EXPECT_EQ(decision.copies == 0, decision.fate != ChaosFate::kForwarded);
  }
  // Five standard deviations of a binomial count of 20000: 212, 154, 283 (of 0.2 * 0.9), 70.
  EXPECT_NEAR(lost, 2000, 212);
  EXPECT_NEAR(held, 1000, 154);
  EXPECT_NEAR(twice, 3600, 283);
  EXPECT_NEAR(corrupt, 200, 70);
}

TEST(ChaosPlan, AFaultMoreLeavesTheOthersAsTheyWere) {
  ChaosOptions without = kAll;
  without.burst_ns = 0;
  without.corrupt = 0;
  const auto with = decisions(kAll), less = decisions(without);
  for (std::size_t i = 0; i < with.size(); ++i) {
    ASSERT_EQ(with[i].copy[0].held_back, less[i].copy[0].held_back) << i;
    ASSERT_EQ(with[i].copy[0].delay_ns, less[i].copy[0].delay_ns) << i;
    if (with[i].fate == ChaosFate::kLostInBurst) continue;
    ASSERT_EQ(with[i].fate, less[i].fate) << i;
    ASSERT_EQ(with[i].copies, less[i].copies) << i;
  }
}

TEST(ChaosPlan, OutagesLoseAllForTheirLength) {
  const ChaosOptions options{.burst_ns = 200'000'000, .burst_interval_ns = 1'000'000'000};
  ChaosPlan plan(options);
  std::size_t lost = 0, run = 0;
  for (int i = 0; i < 20'000; ++i) {
    const bool in_burst = plan.decide(100, i * kStepNs).fate == ChaosFate::kLostInBurst;
    lost += in_burst ? 1 : 0;
    // 200 ms hold 50 datagrams that come every 4 ms, or 49 or 51 by where it begins; two can follow each other closely.
    EXPECT_TRUE(in_burst || run == 0 || run >= 49) << run;
    run = in_burst ? run + 1 : 0;
  }
  // 80 s of an outage each 1.2 s on average: 67, and the number of a Poisson-like process within five deviations of
  // that.
  EXPECT_NEAR(static_cast<double>(plan.bursts()), 67, 35);
  EXPECT_NEAR(static_cast<double>(lost), static_cast<double>(plan.bursts()) * 50, 51);
}

TEST(ChaosPlan, NamesOptionsOutOfRange) {
  EXPECT_THROW(ChaosPlan({.loss = 1.1}), UserError);
  EXPECT_THROW(ChaosPlan({.reorder = -0.1}), UserError);
  EXPECT_THROW(ChaosPlan({.burst_ns = -1}), UserError);
  EXPECT_THROW(ChaosPlan({.burst_interval_ns = 0}), UserError);
  EXPECT_THROW(ChaosPlan({.jitter_ns = -1}), UserError);
}

}  // namespace
}  // namespace risorius
