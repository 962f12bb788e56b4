// What bench_transition leaves behind: rows per transition, and the tables of seed 003 re-made.
#pragma once

#include <filesystem>
#include <vector>

#include "bench/transition_runs.h"

namespace risorius::bench {

/// transition.csv (a row per transition and model), transition_aus.csv (per person, AU and model),
/// transition_jumps.csv (first generated frame).
void write_transition_csv(const std::filesystem::path& folder, const TransitionCases& cases,
                          const std::vector<ModelResult>& results);

/// Of the performed transitions, the truth among the models where a table asks for it: absolute-error.*, jumps.csv and
/// jumps-MODEL.png, ratings.csv and rating-matrix-MODEL.png, summary.*. Throws UserError for a folder that cannot be
/// written.
void write_seed003_tables(const std::filesystem::path& folder, const TransitionCases& cases,
                          const std::vector<ModelResult>& results);

}  // namespace risorius::bench
