#include "replay/evaluation/expression_table_csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdexcept>

#include "replay/corpus/expression_corpus.h"

namespace risorius {
namespace {

template <class Row>
std::string key_of(const Row& row) {
  return fmt::format("{},{},{},{:d},{:d}", row.from, row.to, row.variant + 1, row.is_seen,
                     is_seed003_pair(row.from, row.to));
}

}  // namespace

std::string error_csv(std::span<const ScoredModel> models) {
  std::string text = "from,to,variant,seen,seed003";
  for (const ScoredModel& model : models) text += "," + model.name;
  text += "\n";
  for (const ErrorRow& row : error_rows(models))
    text += fmt::format("{},{:.4f}\n", key_of(row), fmt::join(row.errors, ","));
  return text;
}

std::string jump_csv(std::span<const ScoredModel> models, const std::vector<std::string>& au_names) {
  std::string text = fmt::format("model,from,to,variant,seen,seed003,{},least,mean,most\n", fmt::join(au_names, ","));
  for (const ScoredModel& model : models) {
    for (const JumpRow& row : jump_rows(model)) {
      if (row.percent.size() != au_names.size())
        throw std::invalid_argument("jump_csv: " + model.name + " has other AUs than there are names");
      text += fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f}\n", model.name, key_of(row), fmt::join(row.percent, ","),
                          row.least, row.mean, row.most);
    }
  }
  return text;
}

std::string rating_csv(std::span<const ScoredModel> models) {
  std::string text =
      "model,from,to,variant,seen,seed003,summed_error,largest_jump_percent,third_jump_percent,reactivation_percent,"
      "end_percent,rating\n";
  for (const ScoredModel& model : models) {
    for (const ScoredTransition& one : model.transitions) {
      const Conspicuousness& c = one.conspicuousness;
      text += fmt::format("{},{},{:.4f},{:.3f},{:.3f},{:.3f},{:.3f},{}\n", model.name, key_of(one), c.summed_error,
                          c.largest_jump_percent, c.third_jump_percent, c.reactivation_percent, c.end_percent,
                          symbol_of(c.rating()));
    }
  }
  return text;
}

std::string summary_csv(std::span<const ScoredModel> models) {
  std::string text =
      "model,seen,pairs,transitions,mean_error,mean_jump_percent,largest_jump_percent,inconspicuous,narrow,"
      "conspicuous\n";
  for (const ScoredModel& model : models) {
    for (const bool seen : {true, false}) {
      for (const TablePairs pairs : {TablePairs::kAll, TablePairs::kSeed003}) {
        const TableSummary s = table_summary(model, seen, pairs);
        text += fmt::format("{},{:d},{},{},{:.4f},{:.3f},{:.3f},{},{},{}\n", model.name, seen,
                            pairs == TablePairs::kAll ? "all" : "seed003", s.count, s.mean_error, s.mean_jump_percent,
                            s.largest_jump_percent, s.inconspicuous, s.narrow, s.conspicuous);
      }
    }
  }
  return text;
}

}  // namespace risorius
