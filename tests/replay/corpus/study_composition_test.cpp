#include "replay/corpus/study_composition.h"

#include <array>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <stdexcept>

#include "replay/corpus/expression_corpus.h"

namespace {

using namespace risorius;

using Counts = std::map<std::string, int>;

/// Over the 30 directed pairs of seed 003's six expressions, more variants than it has.
template <class Use>
void for_all_held(char study, Use use) {
  const std::array<std::string, 6> six{"disgusted", "frowning", "happy", "neutral", "sad", "surprised"};
  for (const std::string& from : six) {
    for (const std::string& to : six) {
      for (std::size_t variant = 0; variant < 8; ++variant) {
        if (study_holds(study, from, to, variant)) use(from, to, variant);
      }
    }
  }
}

int count_of(char study) {
  int count = 0;
  for_all_held(study, [&](const auto&...) { ++count; });
  return count;
}

TEST(StudyComposition, HasAsManyTransitionsAsSeed003sTable53Says) {
  const std::map<char, int> total{{'a', 35}, {'b', 45}, {'c', 55}, {'d', 65}, {'e', 75},
                                  {'f', 60}, {'g', 45}, {'h', 65}, {'i', 85}};
  for (const auto& [study, count] : total) EXPECT_EQ(count_of(study), count) << study;
  EXPECT_EQ(total.size(), kStudyModels.size());
}

TEST(StudyComposition, TheWholeDataSetHasTheImbalanceOfTable42) {
  Counts starts, targets;
  for_all_held('i', [&](const std::string& from, const std::string& to, std::size_t) {
    ++starts[from];
    ++targets[to];
  });
  EXPECT_EQ(
      starts,
      (Counts{{"disgusted", 10}, {"frowning", 10}, {"happy", 25}, {"neutral", 15}, {"sad", 10}, {"surprised", 15}}));
  EXPECT_EQ(
      targets,
      (Counts{{"disgusted", 10}, {"frowning", 10}, {"happy", 25}, {"neutral", 15}, {"sad", 5}, {"surprised", 20}}));
}

TEST(StudyComposition, ModelAHasTheTotalsOfTable52) {
  Counts starts, targets;
  int surprised = 0;
  for_all_held('a', [&](const std::string& from, const std::string& to, std::size_t) {
    ++starts[from];
    ++targets[to];
    if (from == "surprised" || to == "surprised") ++surprised;
  });
  EXPECT_EQ(starts, (Counts{{"disgusted", 5}, {"frowning", 5}, {"neutral", 10}, {"sad", 5}, {"surprised", 10}}));
  EXPECT_EQ(targets, (Counts{{"disgusted", 5}, {"frowning", 5}, {"neutral", 10}, {"surprised", 15}}));
  EXPECT_EQ(surprised, 25) << "71.43 % of 35, seed 003's 7.1";
}

TEST(StudyComposition, AddsWhatTable53Adds) {
  const auto added = [](char study) {
    Counts counts;
    for_all_held(study, [&](const std::string& from, const std::string& to, std::size_t) {
      if (from == "happy" || to == "happy") ++counts[from + " > " + to];
    });
    return counts;
  };
  EXPECT_TRUE(added('a').empty());
  EXPECT_EQ(added('b'), (Counts{{"happy > sad", 5}, {"sad > happy", 5}}));
  EXPECT_EQ(added('c').at("disgusted > happy"), 5);
  EXPECT_EQ(added('d').at("happy > surprised"), 5);
  EXPECT_EQ(added('e').at("neutral > happy"), 5);
  EXPECT_EQ(added('e').count("happy > frowning"), 0u);
  EXPECT_EQ(added('f').size(), 5u);
  EXPECT_EQ(added('f').count("neutral > happy"), 0u);
  for (const auto& [pair, count] : added('g')) EXPECT_EQ(count, 1) << pair;
  for (const auto& [pair, count] : added('h')) EXPECT_EQ(count, 3) << pair;
  EXPECT_EQ(added('g').size(), 10u);
  EXPECT_EQ(added('h').size(), 10u);
}

TEST(StudyComposition, RefusesAModelThatTheStudyDoesNotHave) {
  EXPECT_THROW(study_holds('j', "happy", "sad", 0), std::invalid_argument);
  EXPECT_THROW(study_holds('\0', "happy", "sad", 0), std::invalid_argument);
  EXPECT_FALSE(study_holds('i', "happy", "angry", 0)) << "no expression of seed 003";
  EXPECT_FALSE(study_holds('i', "happy", "happy", 0));
  EXPECT_FALSE(study_holds('i', "happy", "sad", kStudyVariants));
}

TEST(StudyComposition, PerformsWhatTheModelLearnsAndHoldsOutTheSameForAll) {
  const std::vector<std::string> names{"AU1", "AU12L", "AU12R"};
  const TransitionCorpus a = study_corpus(names, 'a', 3), g = study_corpus(names, 'g', 3);
  EXPECT_EQ(part_of(a, CorpusPart::kTrain).size(), 35u);
  EXPECT_EQ(part_of(g, CorpusPart::kTrain).size(), 45u);
  for (const CorpusPart part : {CorpusPart::kValidation, CorpusPart::kTest}) {
    const auto of_a = part_of(a, part), of_g = part_of(g, part);
    ASSERT_EQ(of_a.size(), 17u);
    ASSERT_EQ(of_g.size(), 17u);
    for (std::size_t i = 0; i < 17; ++i) EXPECT_EQ(of_a[i]->course, of_g[i]->course);
  }
  std::set<std::string> learnt, held;
  for (const Transition& one : g.transitions) (one.part == CorpusPart::kTrain ? learnt : held).insert(one.sibling);
  for (const std::string& sibling : held) EXPECT_EQ(learnt.count(sibling), 0u) << "a sibling of what is tested on";
}

}  // namespace
