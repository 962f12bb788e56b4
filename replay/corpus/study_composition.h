// Seed 003's study of what data a generator needs: which of the 85 transitions of its Table 4.2 each of its models a to
// i learnt from (its 5.5, Tables 5.2 and 5.3).
//
//   a  none from or to happy: 35                      f  a, and all from happy: 60
//   b  a, and happy from and to sad: 45               g  a, and one variant of all from and to happy: 45
//   c  b, and happy from and to disgusted: 55         h  a, and three variants of all from and to happy: 65
//   d  c, and happy from and to surprised: 65         i  all: 85
//   e  d, and happy from and to neutral: 75
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "replay/corpus/transition_corpus.h"

namespace risorius {

inline constexpr std::string_view kStudyModels = "abcdefghi";
inline constexpr std::size_t kStudyVariants = 5;

/// Whether model `study` learnt from this variant, counted from 0. Throws std::invalid_argument for another letter.
bool study_holds(char study, std::string_view from, std::string_view to, std::size_t variant);

/// Performed (perform_expressions): what the model learns from, all of it for training; beside it, for every study the
/// same, two more variants of all 17 pairs, one for validation and one to test on. Seed 003 drew both out of what it
/// had tripled by interpolation, so that siblings of a tested sequence were learnt; here none is.
TransitionCorpus study_corpus(const std::vector<std::string>& names, char study, std::uint64_t seed);

}  // namespace risorius
