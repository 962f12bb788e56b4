// Transitions between seed 003's six expressions, performed: every directed pair of them, in several variants; and the
// 17 pairs that seed 003's own recordings hold, with the imbalance of its Table 4.2.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "replay/corpus/transition_corpus.h"

namespace risorius {

struct ExpressionCorpusOptions {
  std::uint64_t seed = 1;
  std::size_t variants = 5;  ///< of every pair, [1, 100]
};

/// What the shipped weights were trained on, less its two held-out variants. A variant depends on the seed and its own
/// number alone: any corpus of this seed shares its variants with this one.
inline constexpr ExpressionCorpusOptions kShippedPerformances{.seed = 1, .variants = 30};

/// All 30 directed pairs, `variants` of each. One variant of all pairs is one performance and goes to one side of the
/// split: the last to the test, the one before to validation, if there are at least three. The AUs of `names` that the
/// expressions need and that are not there stay masked.
TransitionCorpus perform_expressions(const std::vector<std::string>& names,
                                     const ExpressionCorpusOptions& options = {});

/// Start and target of seed 003's Table 4.2 (its rows are starts): 17 pairs, 5 variants each, 85 transitions.
const std::vector<std::pair<std::string_view, std::string_view>>& seed003_pairs();
bool is_seed003_pair(std::string_view from, std::string_view to);

/// Of a performed corpus, what seed 003's recordings hold.
TransitionCorpus only_pairs(const TransitionCorpus& corpus,
                            const std::vector<std::pair<std::string_view, std::string_view>>& pairs);

/// The AUs of the shipped ARKit table that can be read from its shapes, in its order: what a corpus of performed and
/// recorded faces has in common.
std::vector<std::string> corpus_aus();

}  // namespace risorius
