// The tables by which seed 003 judges its models, for any generators of transitions: absolute error per transition (its
// Tables 6.6 to 6.8), jumps at the first generated frame (6.1 to 6.5 and appendix C), ratings from expression to
// expression (7.1). Here is their arithmetic; expression_table_files.h writes and draws them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "replay/corpus/transition_corpus.h"
#include "replay/evaluation/conspicuousness.h"

namespace risorius {

/// One transition as one model made it.
struct ScoredTransition {
  std::string from, to;
  std::size_t variant = 0;            ///< counted from 0
  bool is_seen = false;               ///< trained on
  std::vector<double> jumps_percent;  ///< per AU: |x1 - x0|
  Conspicuousness conspicuousness;
};

/// `made` as many rows as the course. Throws std::invalid_argument for sizes that do not fit.
ScoredTransition score_for_tables(const Transition& truth, const AuMatrix& made, bool is_seen);

struct ScoredModel {
  std::string name;
  std::vector<ScoredTransition> transitions;
};

struct ErrorRow {
  std::string from, to;
  std::size_t variant = 0;
  bool is_seen = false;
  std::vector<double> errors;  ///< E per model, in their order
};
/// By expressions in the order of the alphabet, which is that of seed 003's tables, then by variant. Throws
/// std::invalid_argument where the models did not make the same transitions.
std::vector<ErrorRow> error_rows(std::span<const ScoredModel> models);

struct JumpRow {
  std::string from, to;
  std::size_t variant = 0;
  bool is_seen = false;
  std::vector<double> percent;           ///< per AU
  double least = 0, mean = 0, most = 0;  ///< of them
};
/// In the order of error_rows.
std::vector<JumpRow> jump_rows(const ScoredModel& model);

struct RatingCell {
  std::vector<TransitionRating> ratings;  ///< of the variants, in their order; none: no such transition
  TransitionRating worst() const noexcept;
};
struct RatingMatrix {
  std::vector<std::string> expressions;        ///< in the order of the alphabet
  std::vector<std::vector<RatingCell>> cells;  ///< [from][to]
};
/// Of what was trained on, or of what was not.
RatingMatrix rating_matrix(const ScoredModel& model, bool of_seen);

/// Of some transitions together.
struct TableSummary {
  std::size_t count = 0;
  double mean_error = 0;         ///< E; 0 where there are no transitions, as all means
  double mean_jump_percent = 0;  ///< over transitions and AUs: seed 003's 5.52 % of its model i
  double largest_jump_percent = 0;
  std::size_t inconspicuous = 0, narrow = 0, conspicuous = 0;
};
enum class TablePairs : bool { kAll, kSeed003 };  ///< kSeed003: the 17 of its Table 4.2
TableSummary table_summary(const ScoredModel& model, bool of_seen, TablePairs pairs = TablePairs::kAll);

}  // namespace risorius
