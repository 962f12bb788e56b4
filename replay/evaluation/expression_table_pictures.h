// The tables of expression_tables.h drawn. Variants count from 1, with a star where they were never trained on; bold
// are the pairs of seed 003's Table 4.2.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "replay/evaluation/expression_tables.h"
#include "replay/picture/canvas.h"

namespace risorius {

/// Seed 003's Tables 6.6 to 6.8: a row per transition, a column per model.
Canvas error_picture(std::span<const ScoredModel> models);

/// Its Tables 6.1 to 6.5 and appendix C: of each pair the first and the last variant, a column per AU.
Canvas jump_picture(const ScoredModel& model, const std::vector<std::string>& au_names);

/// Its Table 7.1, for what was trained on and for what was not: a sign per variant, the colour that of the worst.
Canvas rating_picture(const ScoredModel& model);

/// Means and counts, a row per model.
Canvas summary_picture(std::span<const ScoredModel> models);

}  // namespace risorius
