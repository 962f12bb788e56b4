// The tables of expression_tables.h as CSV text. Variants count from 1, as in seed 003; `seen` and `seed003` (a pair of
// its Table 4.2) are 1 or 0.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "replay/evaluation/expression_tables.h"

namespace risorius {

/// A row per transition, a column per model: E.
std::string error_csv(std::span<const ScoredModel> models);

/// A row per model and transition, a column per AU (as many names as jumps), then least, mean and most; % of the full
/// range.
std::string jump_csv(std::span<const ScoredModel> models, const std::vector<std::string>& au_names);

/// A row per model and transition: the criteria's quantities and the rating.
std::string rating_csv(std::span<const ScoredModel> models);

/// A row per model, seen or not, all pairs or seed 003's.
std::string summary_csv(std::span<const ScoredModel> models);

}  // namespace risorius
