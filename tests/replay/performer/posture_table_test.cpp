#include "replay/performer/posture_table.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace risorius;

/// Three AUs: the first two go together, the third against them; levels of the second are twice the first's.
PostureTable small_table() {
  PostureTable table{{"AU1", "AU2", "AU4"}, {}, Eigen::MatrixXd::Identity(3, 3)};
  for (const double top : {0.4, 0.8, 0.5}) {
    PostureTable::Levels& levels = table.levels.emplace_back();
    for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = top * PostureTable::kShares[i];
  }
  table.correlation(0, 1) = table.correlation(1, 0) = 0.8;
  table.correlation(0, 2) = table.correlation(2, 0) = -0.5;
  table.correlation(1, 2) = table.correlation(2, 1) = -0.4;
  return table;
}

double correlation_of(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ma += a[i] / static_cast<double>(a.size());
    mb += b[i] / static_cast<double>(a.size());
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

TEST(NormalScores, AreTheRanksScoresAndTiesShareTheirs) {
  const std::vector<double> scores = normal_scores(std::vector<double>{5, 1, 5, 9});
  EXPECT_NEAR(scores[0], 0, 1e-12);
  EXPECT_EQ(scores[0], scores[2]);
  EXPECT_NEAR(scores[1], -1.1503493803760079, 1e-9);  // the normal quantile of 1/8
  EXPECT_NEAR(scores[3], 1.1503493803760079, 1e-9);
}

TEST(PostureSampler, DrawsTheTablesLevelsAndCorrelations) {
  const PostureTable table = small_table();
  PostureSampler sampler(table);
  Random random(3, 1);
  std::vector<std::vector<double>> drawn(3);
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    sampler.renew(0, random);
    for (std::size_t k = 0; k < 3; ++k) drawn[k].push_back(sampler.level(k));
  }
  // Ranks of a normal copula: 6 / pi asin(r / 2) (Pearson 1907); 20,000 draws scatter by less than 0.01.
  const auto rank = [](double r) { return 6 / 3.14159265358979 * std::asin(r / 2); };
  EXPECT_NEAR(correlation_of(drawn[0], drawn[1]), rank(0.8), 0.02);
  EXPECT_NEAR(correlation_of(drawn[0], drawn[2]), rank(-0.5), 0.03);
  std::sort(drawn[1].begin(), drawn[1].end());
  EXPECT_NEAR(drawn[1][kDraws / 2], 0.4, 0.01);
  EXPECT_NEAR(drawn[1][kDraws * 9 / 10], 0.72, 0.01);
  EXPECT_LE(drawn[1].back(), 0.8);
}

TEST(PostureSampler, KeepsAsMuchOfAPostureAsAsked) {
  const PostureTable table = small_table();
  PostureSampler sampler(table);
  Random random(4, 1);
  std::vector<double> before, after;
  for (int i = 0; i < 20000; ++i) {
    sampler.renew(0, random);
    before.push_back(sampler.level(0));
    sampler.renew(0.7, random);
    after.push_back(sampler.level(0));
  }
  EXPECT_NEAR(correlation_of(before, after), 6 / 3.14159265358979 * std::asin(0.35), 0.02);
}

TEST(PostureSampler, WhatLeadsIsWhereItIsAskedAndTheOthersFollow) {
  const PostureTable table = small_table();
  PostureSampler sampler(table);
  Random random(5, 1);
  double follower = 0, opponent = 0;
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    sampler.renew(0, random);
    const PostureSampler::Lead lead{0, sampler.share_of(0, 0.36)};
    sampler.lead(std::span(&lead, 1));
    ASSERT_NEAR(sampler.level(0), 0.36, 1e-9);
    follower += sampler.level(1) / kDraws;
    opponent += sampler.level(2) / kDraws;
  }
  // Score 1.2816 of the share 0.9. The mean share of a normal with mean m and variance v is Phi(m / sqrt(1 + v)).
  const auto mean_share = [](double r) {
    return 0.5 * std::erfc(-r * 1.2815515655 / std::sqrt(1 + 1 - r * r) / std::sqrt(2));
  };
  EXPECT_NEAR(follower, 0.8 * mean_share(0.8), 0.01);
  EXPECT_NEAR(opponent, 0.5 * mean_share(-0.5), 0.01);
}

TEST(PostureSampler, RefusesATableThatIsNone) {
  PostureTable table = small_table();
  table.correlation(0, 1) = table.correlation(1, 0) = -0.99;
  table.correlation(0, 2) = table.correlation(2, 0) = -0.99;
  table.correlation(1, 2) = table.correlation(2, 1) = -0.99;
  EXPECT_THROW(PostureSampler{table}, std::invalid_argument);
  table = small_table();
  table.levels.pop_back();
  EXPECT_THROW(PostureSampler{table}, std::invalid_argument);
}

}  // namespace
