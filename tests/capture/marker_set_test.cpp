#include "capture/marker_set.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

TEST(Axes, EveryLetterTripleGoesThereAndBack) {
  int valid = 0;
  for (const char a : std::string("LRUDFB"))
    for (const char b : std::string("LRUDFB"))
      for (const char c : std::string("LRUDFB")) {
        const std::string letters{a, b, c};
        const auto axes = Axes::parse(letters);
        if (!axes) continue;
        ++valid;
        EXPECT_EQ(axes->letters(), letters);
        const Position world = axes->to_world(1, 2, 3);
        EXPECT_EQ(axes->from_world(world), (Position{1, 2, 3})) << letters;
      }
  EXPECT_EQ(valid, 48);  // 3! orders times 2^3 signs
}

TEST(Axes, ConvertsViconZUp) {
  const auto axes = Axes::parse("FLU");  // x forward, y left, z up
  ASSERT_TRUE(axes);
  EXPECT_EQ(axes->to_world(10, 20, 30), (Position{20, 30, 10}));
}

TEST(Axes, RefusesLettersThatAreNotThreeDirections) {
  for (const char* letters : {"", "LU", "LUFB", "LRU", "LLU", "luf", "XYZ"})
    EXPECT_FALSE(Axes::parse(letters)) << letters;
}

TEST(MarkerSet, NamesEveryProblem) {
  MarkerSet set;
  set.names = {"a", "", "a", std::string(64, 'x')};
  set.rate_hz = -1;
  set.mm_per_unit = 0;
  EXPECT_EQ(problems_of(set).size(), 5u);
  set = MarkerSet{.names = {"a", "b"}, .rate_hz = 60};
  EXPECT_TRUE(problems_of(set).empty());
}

TEST(MarkerSet, MapsByName) { EXPECT_EQ(index_map({"a", "b", "c"}, {"c", "x", "a"}), (std::vector<int>{2, -1, 0})); }

}  // namespace
}  // namespace risorius
