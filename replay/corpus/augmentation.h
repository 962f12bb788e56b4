// More transitions out of the ones there are, without copies: other paces, the mirrored face, other strengths.
#pragma once

#include "replay/corpus/transition_corpus.h"
#include "replay/performer/random.h"

namespace risorius {

struct AugmentationOptions {
  double pace = 0.25;       ///< standard deviation of the logarithm of the duration, [0, 1]
  double pace_bend = 0.1;   ///< how unevenly time runs, [0, 0.3]: 0.1 speeds one half up by about 30 %
  double mirror = 0.5;      ///< probability, [0, 1]
  double amplitude = 0.25;  ///< standard deviation of the logarithm, [0, 1]
};

/// `mirrored`: the other side of each AU (generate/au_kind.h). A drawn variation with the same take, sibling and part.
/// Courses keep within the shortest and longest transition (StillnessOptions), values within [0, 1.2].
Transition vary(const Transition& original, const std::vector<std::size_t>& mirrored, Random& random,
                const AugmentationOptions& options = {});

}  // namespace risorius
