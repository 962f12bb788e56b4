#include "replay/study/study_pairs.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <stdexcept>

namespace risorius {
namespace {

using Comparison = std::pair<std::size_t, std::size_t>;

Comparison comparison_of(const StudyPair& pair) { return std::minmax(pair.left, pair.right); }

template <class Map>
std::size_t spread_of(const Map& counts, std::size_t all) {
  std::size_t least = counts.size() < all ? 0 : SIZE_MAX, most = 0;
  for (const auto& [what, count] : counts) {
    least = std::min(least, count);
    most = std::max(most, count);
  }
  return most - least;
}

TEST(StudyPairs, EveryKindMeetsTheRealOneAndTheDefaultMeetsTheOthers) {
  EXPECT_EQ(study_comparisons(4), (std::vector<Comparison>{{1, 0}, {2, 0}, {3, 0}, {1, 2}, {1, 3}}));
  EXPECT_EQ(study_comparisons(2), (std::vector<Comparison>{{1, 0}}));
  EXPECT_THROW(study_comparisons(1), std::invalid_argument);
}

TEST(StudyPairs, ComparisonsTransitionsAndSidesAreBalanced) {
  struct Case {
    std::size_t transitions, kinds, pairs;
  };
  constexpr std::array kCases{Case{60, 4, 40}, Case{7, 4, 35},  Case{10, 4, 33}, Case{9, 3, 27},
                              Case{6, 3, 14},  Case{100, 4, 3}, Case{1, 4, 5},   Case{12, 2, 9}};
  for (const auto [transitions, kinds, count] : kCases) {
    SCOPED_TRACE(testing::Message() << transitions << " transitions, " << kinds << " kinds, " << count << " pairs");
    const auto pairs = draw_study_pairs(transitions, kinds, count, 7);
    ASSERT_EQ(pairs.size(), count);
    std::map<Comparison, std::size_t> of_comparison, ordered;
    std::map<std::size_t, std::size_t> of_transition;
    std::set<std::pair<std::size_t, Comparison>> met;
    for (const StudyPair& pair : pairs) {
      ASSERT_LT(pair.transition, transitions);
      ASSERT_NE(pair.left, pair.right);
      ++of_comparison[comparison_of(pair)];
      ++ordered[{pair.left, pair.right}];
      ++of_transition[pair.transition];
      EXPECT_TRUE(met.insert({pair.transition, comparison_of(pair)}).second) << "shown twice";
    }
    EXPECT_LE(spread_of(of_comparison, study_comparisons(kinds).size()), 1u);
    EXPECT_LE(spread_of(of_transition, transitions), 1u);
    for (const auto& [comparison, all] : of_comparison) {
      const auto left = static_cast<long>(ordered[comparison]), right = static_cast<long>(all) - left;
      EXPECT_LE(std::abs(left - right), 1) << "sides of " << comparison.first << ", " << comparison.second;
    }
  }
}

TEST(StudyPairs, TheSeedDecidesOrderAndSides) {
  const auto same = [](const std::vector<StudyPair>& a, const std::vector<StudyPair>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const StudyPair& p, const StudyPair& q) {
      return p.transition == q.transition && p.left == q.left && p.right == q.right;
    });
  };
  const auto first = draw_study_pairs(30, 4, 40, 1);
  EXPECT_TRUE(same(first, draw_study_pairs(30, 4, 40, 1)));
  EXPECT_FALSE(same(first, draw_study_pairs(30, 4, 40, 2)));
  // Neither the comparisons nor the transitions come one after the other.
  std::size_t repeats = 0;
  for (std::size_t i = 1; i < first.size(); ++i)
    repeats += comparison_of(first[i]) == comparison_of(first[i - 1]) ? 1 : 0;
  EXPECT_LT(repeats, first.size() / 2);
}

TEST(StudyPairs, MorePairsThanThereAreAreRefused) {
  EXPECT_EQ(draw_study_pairs(4, 3, 12, 1).size(), 12u);
  EXPECT_THROW(draw_study_pairs(4, 3, 13, 1), std::invalid_argument);
  EXPECT_THROW(draw_study_pairs(0, 3, 1, 1), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
