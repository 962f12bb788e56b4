#include "replay/evaluation/expression_tables.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>

#include "replay/corpus/expression_corpus.h"
#include "replay/evaluation/transition_score.h"

namespace risorius {
namespace {

auto key_of(const ScoredTransition& one) { return std::tie(one.from, one.to, one.variant); }

/// Pointers in the tables' order. Throws std::invalid_argument where one is there twice.
std::vector<const ScoredTransition*> in_order(const ScoredModel& model) {
  std::vector<const ScoredTransition*> order;
  for (const ScoredTransition& one : model.transitions) order.push_back(&one);
  std::sort(order.begin(), order.end(),
            [](const ScoredTransition* a, const ScoredTransition* b) { return key_of(*a) < key_of(*b); });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (key_of(*order[i - 1]) == key_of(*order[i]))
      throw std::invalid_argument("expression tables: " + model.name + " has a transition twice");
  }
  return order;
}

}  // namespace

ScoredTransition score_for_tables(const Transition& truth, const AuMatrix& made, bool is_seen) {
  return {.from = truth.from,
          .to = truth.to,
          .variant = truth.variant,
          .is_seen = is_seen,
          .jumps_percent = start_jumps_percent(truth.past, made),
          .conspicuousness = conspicuousness_of(truth.past, truth.course, made)};
}

std::vector<ErrorRow> error_rows(std::span<const ScoredModel> models) {
  std::vector<ErrorRow> rows;
  for (std::size_t m = 0; m < models.size(); ++m) {
    const std::vector<const ScoredTransition*> order = in_order(models[m]);
    if (m == 0) {
      for (const ScoredTransition* one : order) rows.push_back({one->from, one->to, one->variant, one->is_seen, {}});
    }
    if (order.size() != rows.size())
      throw std::invalid_argument("error_rows: " + models[m].name + " did not make as many transitions");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (std::tie(rows[i].from, rows[i].to, rows[i].variant) != key_of(*order[i]))
        throw std::invalid_argument("error_rows: " + models[m].name + " made other transitions");
      rows[i].errors.push_back(order[i]->conspicuousness.summed_error);
    }
  }
  return rows;
}

std::vector<JumpRow> jump_rows(const ScoredModel& model) {
  std::vector<JumpRow> rows;
  for (const ScoredTransition* one : in_order(model)) {
    const std::vector<double>& jumps = one->jumps_percent;
    if (jumps.empty()) throw std::invalid_argument("jump_rows: a transition without AUs");
    const auto [least, most] = std::minmax_element(jumps.begin(), jumps.end());
    const double mean = std::accumulate(jumps.begin(), jumps.end(), 0.0) / static_cast<double>(jumps.size());
    rows.push_back({one->from, one->to, one->variant, one->is_seen, jumps, *least, mean, *most});
  }
  return rows;
}

TransitionRating RatingCell::worst() const noexcept {
  return ratings.empty() ? TransitionRating::kInconspicuous : *std::max_element(ratings.begin(), ratings.end());
}

RatingMatrix rating_matrix(const ScoredModel& model, bool of_seen) {
  std::set<std::string> names;
  for (const ScoredTransition& one : model.transitions) names.insert({one.from, one.to});
  RatingMatrix matrix{{names.begin(), names.end()}, {}};
  matrix.cells.assign(names.size(), std::vector<RatingCell>(names.size()));
  const auto place = [&](const std::string& name) {
    return static_cast<std::size_t>(std::distance(names.begin(), names.find(name)));
  };
  for (const ScoredTransition* one : in_order(model)) {
    if (one->is_seen == of_seen)
      matrix.cells[place(one->from)][place(one->to)].ratings.push_back(one->conspicuousness.rating());
  }
  return matrix;
}

TableSummary table_summary(const ScoredModel& model, bool of_seen, TablePairs pairs) {
  TableSummary sum;
  std::size_t jumps = 0;
  for (const ScoredTransition& one : model.transitions) {
    if (one.is_seen != of_seen || (pairs == TablePairs::kSeed003 && !is_seed003_pair(one.from, one.to))) continue;
    ++sum.count;
    sum.mean_error += one.conspicuousness.summed_error;
    jumps += one.jumps_percent.size();
    for (const double jump : one.jumps_percent) {
      sum.mean_jump_percent += jump;
      sum.largest_jump_percent = std::max(sum.largest_jump_percent, jump);
    }
    const TransitionRating rating = one.conspicuousness.rating();
    ++(rating == TransitionRating::kInconspicuous ? sum.inconspicuous
       : rating == TransitionRating::kNarrow      ? sum.narrow
                                                  : sum.conspicuous);
  }
  if (sum.count > 0) sum.mean_error /= static_cast<double>(sum.count);
  if (jumps > 0) sum.mean_jump_percent /= static_cast<double>(jumps);
  return sum;
}

}  // namespace risorius
