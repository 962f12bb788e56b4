#include "replay/study/study_pairs.h"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

#include "replay/performer/random.h"

namespace risorius {
namespace {

// Streams of the seed, so that one draw does not change another.
constexpr std::uint64_t kTransitionStream = 1, kComparisonStream = 2, kSideStream = 3, kOrderStream = 4;

/// std::shuffle gives other orders on other standard libraries.
template <class Value>
void shuffle(std::vector<Value>& values, Random& random) {
  for (std::size_t left = values.size(); left > 1; --left) {
    const std::size_t chosen = random.index(left);
    std::swap(values[left - 1], values[chosen]);
  }
}

/// Half of them true, in random places; of an odd count the one too many is drawn.
std::vector<bool> balanced_flags(std::size_t count, Random& random) {
  const std::size_t trues = count / 2 + (count % 2 == 1 && random.chance(0.5) ? 1 : 0);
  std::vector<char> flags(count, 0);
  std::fill_n(flags.begin(), trues, 1);
  shuffle(flags, random);
  return {flags.begin(), flags.end()};
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> study_comparisons(std::size_t kinds) {
  if (kinds < 2) throw std::invalid_argument("study_comparisons: a comparison needs two kinds");
  std::vector<std::pair<std::size_t, std::size_t>> comparisons;
  for (std::size_t kind = kStudyDefault; kind < kinds; ++kind) comparisons.emplace_back(kind, kStudyReal);
  for (std::size_t kind = kStudyDefault + 1; kind < kinds; ++kind) comparisons.emplace_back(kStudyDefault, kind);
  return comparisons;
}

std::vector<StudyPair> draw_study_pairs(std::size_t transitions, std::size_t kinds, std::size_t count,
                                        std::uint64_t seed) {
  auto comparisons = study_comparisons(kinds);
  if (count > transitions * comparisons.size()) {
    throw std::invalid_argument(fmt::format("draw_study_pairs: {} pairs of {} transitions in {} comparisons", count,
                                            transitions, comparisons.size()));
  }
  Random of_transitions(seed, kTransitionStream), of_comparisons(seed, kComparisonStream), of_sides(seed, kSideStream),
      of_order(seed, kOrderStream);
  std::vector<std::size_t> order(transitions);
  std::iota(order.begin(), order.end(), std::size_t{0});
  shuffle(order, of_transitions);
  shuffle(comparisons, of_comparisons);

  // Both walk round and round; they meet again after lcm(transitions, comparisons) pairs, where the comparisons are
  // moved on by one. So every transition meets every comparison before it meets one twice.
  std::vector<std::vector<std::size_t>> of_comparison(comparisons.size());
  std::vector<StudyPair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t moved = i / std::lcm(transitions, comparisons.size());
    const std::size_t comparison = (i + moved) % comparisons.size();
    of_comparison[comparison].push_back(i);
    pairs.push_back({order[i % transitions], comparisons[comparison].first, comparisons[comparison].second});
  }
  for (const std::vector<std::size_t>& members : of_comparison) {
    const std::vector<bool> swapped = balanced_flags(members.size(), of_sides);
    for (std::size_t k = 0; k < members.size(); ++k) {
      if (swapped[k]) std::swap(pairs[members[k]].left, pairs[members[k]].right);
    }
  }
  shuffle(pairs, of_order);
  return pairs;
}

}  // namespace risorius
