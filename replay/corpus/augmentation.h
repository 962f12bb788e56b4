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
  /// Probability, [0, 1], that it begins under way, between 0.1 and 0.7 of the course: a live target comes when it
  /// comes.
  double under_way = 0.5;
};

/// `mirrored`: the other side of each AU (generate/au_kind.h). A drawn variation with the same take, sibling and part.
/// Courses keep within the shortest and longest transition (StillnessOptions) but for those that begin under way,
/// values within [0, 1.2].
Transition vary(const Transition& original, const std::vector<std::size_t>& mirrored, Random& random,
                const AugmentationOptions& options = {});

/// The rest of a transition from row `first` of its course on: what comes before is past. 0 <= first < rows.
Transition under_way(const Transition& whole, Eigen::Index first);

}  // namespace risorius
