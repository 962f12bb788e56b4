// Which pairs a blind comparison shows: two kinds (the recorded course, or a generator's) of one transition side by
// side. Kinds and transitions are indices here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace risorius {

/// Of the kinds: the recorded course, and the default generator.
inline constexpr std::size_t kStudyReal = 0, kStudyDefault = 1;

struct StudyPair {
  std::size_t transition = 0;
  std::size_t left = 0, right = 0;  ///< kinds
};

/// What is compared: every other kind with kStudyReal, and kStudyDefault with every further one. `kinds` >= 2.
std::vector<std::pair<std::size_t, std::size_t>> study_comparisons(std::size_t kinds);

/// `count` pairs in the order in which they are shown. Comparisons occur equally often, and so do transitions (counts
/// differ by at most one); no transition occurs twice in one comparison; in each comparison either kind is on the left
/// equally often. Order and sides are random; the same seed gives the same pairs. Throws std::invalid_argument: fewer
/// than two kinds, or more pairs than transitions times comparisons.
std::vector<StudyPair> draw_study_pairs(std::size_t transitions, std::size_t kinds, std::size_t count,
                                        std::uint64_t seed);

}  // namespace risorius
