// Every fill method on every gap task of one take, the same draws for all.
#pragma once

#include <string>
#include <vector>

#include "bench/fill_score.h"
#include "bench/gap_protocol.h"
#include "capture/repair/fill_methods.h"

namespace risorius::bench {

struct TaskScores {
  GapTask task;
  std::vector<MethodScore> by_method;  ///< in the order of the methods given

  /// The method with the least mean error among those that may stand against a default: any for the offline one,
  /// causal ones for the causal one.
  std::size_t best_baseline(const std::vector<const FillMethodEntry*>& methods, bool causal_only) const;
};

/// Draws in parallel; prints one line of progress on stderr. Tasks that the take has no room for are left out, with a
/// line that says why.
std::vector<TaskScores> score_fills(const test::MarkerTake& clean, const std::vector<GapTask>& tasks,
                                    const std::vector<const FillMethodEntry*>& methods, int draws);

void print_fill_table(const std::vector<TaskScores>& scores, const std::vector<const FillMethodEntry*>& methods);
/// task, method, mean, rmse, coverage, crps stated, crps calibrated, steps.
void write_fill_csv(const std::string& path, const std::vector<TaskScores>& scores,
                    const std::vector<const FillMethodEntry*>& methods);

}  // namespace risorius::bench
