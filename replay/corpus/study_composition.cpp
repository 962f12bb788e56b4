#include "replay/corpus/study_composition.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

#include "replay/corpus/expression_corpus.h"

namespace risorius {
namespace {

constexpr std::string_view kHappy = "happy";
/// Models b to e add one after the other.
constexpr std::array<std::string_view, 4> kAdded{"sad", "disgusted", "surprised", "neutral"};

}  // namespace

bool study_holds(char study, std::string_view from, std::string_view to, std::size_t variant) {
  if (kStudyModels.find(study) == std::string_view::npos)
    throw std::invalid_argument(fmt::format("study_holds: no model '{}'; there are a to i", study));
  if (variant >= kStudyVariants || !is_seed003_pair(from, to)) return false;
  if (from != kHappy && to != kHappy) return true;
  const std::string_view other = from == kHappy ? to : from;
  switch (study) {
    case 'a':
      return false;
    case 'f':
      return from == kHappy;
    case 'g':
      return variant < 1;
    case 'h':
      return variant < 3;
    case 'i':
      return true;
    default:
      return std::find(kAdded.begin(), kAdded.end(), other) - kAdded.begin() < study - 'a';
  }
}

TransitionCorpus study_corpus(const std::vector<std::string>& names, char study, std::uint64_t seed) {
  // The last two variants of a performed corpus are held out.
  const TransitionCorpus all = only_pairs(perform_expressions(names, {seed, kStudyVariants + 2}), seed003_pairs());
  TransitionCorpus result{all.names, all.rate_hz, {}};
  for (const Transition& one : all.transitions) {
    if (one.part != CorpusPart::kTrain || study_holds(study, one.from, one.to, one.variant))
      result.transitions.push_back(one);
  }
  return result;
}

}  // namespace risorius
