#include "bench/transition_runs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "replay/corpus/augmentation.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/progress_line.h"

namespace risorius::bench {
namespace {

constexpr std::size_t kSeenVariants = 3;  // of those trained on; seed 003 has 5 variants of a transition

}  // namespace

TransitionCases transition_cases(const std::vector<std::filesystem::path>& takes, const std::string& trained_take) {
  TransitionCases result{corpus_aus(), {}, SequenceIndex(static_cast<Eigen::Index>(corpus_aus().size()))};
  for (const auto& path : takes) {
    TransitionCorpus corpus{result.names, kCorpusRateHz, {}};
    append(corpus, cut_transitions(motion_of(load_au_recording(path))));
    for (Transition& one : corpus.transitions) {
      const bool is_seen = one.take == trained_take && one.part == CorpusPart::kTrain;
      result.cases.push_back({std::move(one), true, is_seen});
    }
  }
  for (const TransitionCase& one : result.cases) {
    if (one.is_seen) result.trained.add(one.transition.course);
  }
  TransitionCorpus performed = perform_expressions(result.names, kShippedPerformances);
  for (Transition& one : performed.transitions) {
    const bool is_seen = one.part == CorpusPart::kTrain;
    if (is_seen) result.trained.add(one.course);
    if (!is_seen || one.variant < kSeenVariants) result.cases.push_back({std::move(one), false, is_seen});
  }
  return result;
}

TransitionCases begun_under_way(const TransitionCases& cases) {
  TransitionCases begun = cases;
  for (TransitionCase& one : begun.cases) one.transition = under_way(one.transition, one.transition.course.rows() / 3);
  return begun;
}

std::vector<MadeTransition> make_all(const TransitionCases& cases, TransitionModel& model) {
  std::vector<MadeTransition> made;
  ProgressLine progress(std::string(model.name()), "transitions");
  for (const TransitionCase& one : cases.cases) {
    MadeTransition& result = made.emplace_back();
    result.of = &one;
    const Transition& transition = one.transition;
    const TransitionRequest request{.past = transition.past,
                                    .target = transition.course.row(transition.course.rows() - 1).transpose(),
                                    .frames = transition.course.rows(),
                                    .rate_hz = kCorpusRateHz};
    model.generate(request, result.course);
    result.score = score_transition(transition.past, transition.course, result.course, kCorpusRateHz);
    result.nearest_rms = cases.trained.nearest_rms(result.course);
    progress.show(made.size(), cases.cases.size());
  }
  progress.finish(made.size());
  return made;
}

TransitionSummary summary_of(const std::vector<const MadeTransition*>& made) {
  TransitionSummary sum;
  SeamJump seam, truth;
  PowerSpectrumSimilarity similarity;
  sum.nearest_rms = std::numeric_limits<double>::infinity();
  for (const MadeTransition* one : made) {
    const TransitionScore& score = one->score;
    ++sum.count;
    sum.mse += score.mean_squared_error;
    sum.mae += score.mean_absolute_error;
    similarity.add(one->of->transition.course, one->course);
    const double moving = score.moving_aus;  // the seams are means over them
    seam.value += moving * score.seam.value;
    seam.velocity_per_s += moving * score.seam.velocity_per_s;
    seam.acceleration_per_s2 += moving * score.seam.acceleration_per_s2;
    truth.value += moving * score.truth_seam.value;
    truth.velocity_per_s += moving * score.truth_seam.velocity_per_s;
    truth.acceleration_per_s2 += moving * score.truth_seam.acceleration_per_s2;
    sum.mean_jump_percent += score.mean_jump_percent;
    sum.truth_jump_percent += score.truth_jump_percent;
    sum.largest_jump_percent = std::max(sum.largest_jump_percent, score.largest_jump_percent);
    sum.end_error_percent = std::max(sum.end_error_percent, score.end_error_percent);
    sum.end_step_percent = std::max(sum.end_step_percent, score.end_step_percent);
    sum.reactivation_percent += score.reactivation_percent;
    sum.out_of_bounds += score.values_out_of_bounds;
    sum.conspicuous_percent += score.conspicuousness.is_conspicuous() ? 100 : 0;
    sum.nearest_rms = std::min(sum.nearest_rms, one->nearest_rms);
    if (one->nearest_rms < kCopyRms) ++sum.copies;
  }
  const auto count = static_cast<double>(sum.count);
  for (double* mean : {&sum.mse, &sum.mae, &sum.mean_jump_percent, &sum.truth_jump_percent, &sum.reactivation_percent,
                       &sum.conspicuous_percent})
    *mean /= count;
  sum.npss = similarity.value();
  sum.value_ratio = seam.value / truth.value;
  sum.velocity_ratio = seam.velocity_per_s / truth.velocity_per_s;
  sum.acceleration_ratio = seam.acceleration_per_s2 / truth.acceleration_per_s2;
  return sum;
}

}  // namespace risorius::bench
