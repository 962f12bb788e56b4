#include "bench/transition_files.h"

#include <fmt/format.h>
#include <fstream>
#include <map>
#include <string_view>

#include "capture/errors.h"
#include "replay/atomic_file.h"
#include "replay/evaluation/expression_table_csv.h"
#include "replay/evaluation/expression_table_pictures.h"

namespace risorius::bench {
namespace {

void write_text(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

ScoredModel scored(const ModelResult& result) {
  ScoredModel model{result.name, {}};
  for (const MadeTransition& one : result.made) {
    if (!one.of->is_real)
      model.transitions.push_back(score_for_tables(one.of->transition, one.course, one.of->is_seen));
  }
  return model;
}

ScoredModel scored_truth(const TransitionCases& cases) {
  ScoredModel model{"truth", {}};
  for (const TransitionCase& one : cases.cases) {
    if (!one.is_real) model.transitions.push_back(score_for_tables(one.transition, one.transition.course, one.is_seen));
  }
  return model;
}

}  // namespace

void write_transition_csv(const std::filesystem::path& folder, const TransitionCases& cases,
                          const std::vector<ModelResult>& results) {
  std::ofstream each(folder / "transition.csv"), aus(folder / "transition_aus.csv"),
      jumps(folder / "transition_jumps.csv");
  each << "take,begin_s,from,to,variant,real,seen,frames,stray,model,mse,mae,summed_error,seam_value,"
          "seam_value_truth,mean_jump_percent,largest_jump_percent,end_error_percent,reactivation_percent,"
          "out_of_bounds,nearest_rms,conspicuous\n";
  jumps << "take,begin_s,from,to,variant,model,au,last,first,jump_percent\n";
  std::map<std::pair<std::string, std::string>, std::pair<std::vector<double>, double>> by_au;
  for (const ModelResult& result : results) {
    for (const MadeTransition& one : result.made) {
      const Transition& t = one.of->transition;
      const TransitionScore& s = one.score;
      const std::string key = fmt::format("{},{:.3f},{},{},{}", t.take, t.begin_s, t.from, t.to, t.variant);
      each << fmt::format(
          "{},{},{},{},{:.3f},{},{:.6e},{:.6e},{:.4f},{:.6f},{:.6f},{:.3f},{:.3f},{:.3f},{:.3f},{},{:.5f},{}\n", key,
          one.of->is_real ? 1 : 0, one.of->is_seen ? 1 : 0, t.course.rows(), t.stray, result.name, s.mean_squared_error,
          s.mean_absolute_error, s.conspicuousness.summed_error, s.seam.value, s.truth_seam.value, s.mean_jump_percent,
          s.largest_jump_percent, s.end_error_percent, s.reactivation_percent, s.values_out_of_bounds, one.nearest_rms,
          s.conspicuousness.is_conspicuous() ? 1 : 0);
      auto& [sums, count] = by_au[{one.of->is_real ? t.take : "performer", result.name}];
      sums.resize(cases.names.size());
      for (std::size_t au = 0; au < sums.size(); ++au) sums[au] += s.squared_error_by_au[au];
      ++count;
      const std::vector<double> first = start_jumps_percent(t.past, one.course);
      for (std::size_t au = 0; au < first.size(); ++au) {
        const auto column = static_cast<Eigen::Index>(au);
        jumps << fmt::format("{},{},{},{:.4f},{:.4f},{:.3f}\n", key, result.name, cases.names[au],
                             t.past(t.past.rows() - 1, column), one.course(0, column), first[au]);
      }
    }
  }
  aus << "take,model,au,mse\n";
  for (const auto& [key, sums] : by_au) {
    for (std::size_t au = 0; au < cases.names.size(); ++au)
      aus << fmt::format("{},{},{},{:.6e}\n", key.first, key.second, cases.names[au], sums.first[au] / sums.second);
  }
}

void write_seed003_tables(const std::filesystem::path& folder, const TransitionCases& cases,
                          const std::vector<ModelResult>& results) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw UserError(folder.string(), "cannot be made: " + error.message(), "name a folder that can be written");
  std::vector<ScoredModel> models;
  for (const ModelResult& result : results) models.push_back(scored(result));
  write_text(folder / "absolute-error.csv", error_csv(models));
  error_picture(models).save_png(folder / "absolute-error.png");
  models.push_back(scored_truth(cases));
  write_text(folder / "jumps.csv", jump_csv(models, cases.names));
  write_text(folder / "ratings.csv", rating_csv(models));
  write_text(folder / "summary.csv", summary_csv(models));
  summary_picture(models).save_png(folder / "summary.png");
  for (const ScoredModel& model : models) {
    jump_picture(model, cases.names).save_png(folder / ("jumps-" + model.name + ".png"));
    rating_picture(model).save_png(folder / ("rating-matrix-" + model.name + ".png"));
  }
}

}  // namespace risorius::bench
