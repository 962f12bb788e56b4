// Every fill method on every gap task of one take, the same draws for all.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/fill_score.h"
#include "bench/gap_protocol.h"
#include "capture/repair/known_motion.h"

namespace risorius::bench {

/// One way to fill, as the bench compares them.
struct Filler {
  std::string name;
  bool is_causal, states_deviation;
  bool is_baseline;     ///< what the defaults are measured against
  bool knows_the_face;  ///< was told how it moves
  std::function<void(std::vector<MarkerFrame>& frames, const MarkerSet& set)> fill;
};

/// The offline default, the causal one, all baselines; then both defaults told how this face moves, if it is known.
std::vector<Filler> fillers(const std::shared_ptr<const KnownMotion>& known);

struct TaskScores {
  GapTask task;
  std::vector<MethodScore> by_method;  ///< in the order of the methods given

  /// The method with the least mean error among those that may stand against a default: any for the offline one,
  /// causal ones for the causal one.
  std::size_t best_baseline(const std::vector<Filler>& methods, bool causal_only) const;
};

/// Draws in parallel; prints one line of progress on stderr. Tasks that the take has no room for are left out, with a
/// line that says why.
std::vector<TaskScores> score_fills(const test::MarkerTake& clean, const std::vector<GapTask>& tasks,
                                    const std::vector<Filler>& methods, int draws);

void print_fill_table(const std::vector<TaskScores>& scores, const std::vector<Filler>& methods);
/// task, method, mean, rmse, coverage, crps stated, crps calibrated, steps.
void write_fill_csv(const std::string& path, const std::vector<TaskScores>& scores, const std::vector<Filler>& methods);

}  // namespace risorius::bench
