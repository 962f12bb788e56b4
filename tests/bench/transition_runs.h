// Transitions to be made again (real ones and performed ones, seen in training or not), and what a model makes of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "generate/transition.h"
#include "replay/corpus/transition_corpus.h"
#include "replay/evaluation/nearest_sequence.h"
#include "replay/evaluation/npss.h"
#include "replay/evaluation/transition_score.h"

namespace risorius::bench {

struct TransitionCase {
  Transition transition;
  bool is_real = false, is_seen = false;  ///< seen: of the part that the shipped model was trained on
};

struct TransitionCases {
  std::vector<std::string> names;  ///< AUs
  std::vector<TransitionCase> cases;
  SequenceIndex trained{0};  ///< all courses that the shipped model was trained on, but for its ranges of motion
};

/// Real ones of these takes, of which `trained_take` was trained on in part; and of the performer's six expressions
/// three variants that were trained on and the two that were held out.
TransitionCases transition_cases(const std::vector<std::filesystem::path>& takes, const std::string& trained_take);

/// All of them from the third of their way on.
TransitionCases begun_under_way(const TransitionCases& cases);

struct MadeTransition {
  const TransitionCase* of = nullptr;
  AuMatrix course;
  TransitionScore score;
  double nearest_rms = 0;  ///< to a seen course
};

/// In the order of the cases. Shows progress.
std::vector<MadeTransition> make_all(const TransitionCases& cases, TransitionModel& model);

/// All that one model made.
struct ModelResult {
  std::string name;
  bool is_interpolation = false;
  std::vector<MadeTransition> made;
};

/// Of some transitions together.
struct TransitionSummary {
  std::size_t count = 0;
  double mse = 0, mae = 0, npss = 0;
  double value_ratio = 0, velocity_ratio = 0, acceleration_ratio = 0;  ///< seam to the truth's
  double mean_jump_percent = 0, largest_jump_percent = 0, truth_jump_percent = 0;
  double end_error_percent = 0, end_step_percent = 0, reactivation_percent = 0;
  int out_of_bounds = 0;
  double conspicuous_percent = 0;
  double nearest_rms = 0;  ///< the least
  int copies = 0;          ///< nearer than kCopyRms to a seen course
};
/// Nearer than what an eye or a marker tells apart.
inline constexpr double kCopyRms = 0.005;

template <class Wanted>
TransitionSummary summary_of(const std::vector<MadeTransition>& made, Wanted wanted);
TransitionSummary summary_of(const std::vector<const MadeTransition*>& made);

template <class Wanted>
TransitionSummary summary_of(const std::vector<MadeTransition>& made, Wanted wanted) {
  std::vector<const MadeTransition*> chosen;
  for (const MadeTransition& one : made) {
    if (wanted(*one.of)) chosen.push_back(&one);
  }
  return summary_of(chosen);
}

}  // namespace risorius::bench
