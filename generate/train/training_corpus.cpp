#include "generate/train/training_corpus.h"

#include <fmt/format.h>

#include "generate/au_kind.h"
#include "replay/corpus/augmentation.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/performer/dynamics_fit.h"

namespace risorius {
namespace {

constexpr std::uint64_t kMotionTakes = 12;
constexpr double kMotionSeconds = 134, kMotionRateHz = 30;  // as alex_rom_3

void add_variations(const TransitionCorpus& corpus, std::size_t count, Random& random, std::vector<Transition>& pool) {
  const std::vector<std::size_t> mirrored = other_sides(corpus.names);
  const std::vector<const Transition*> originals = part_of(corpus, CorpusPart::kTrain);
  for (std::size_t i = 0; i < count && !originals.empty(); ++i) {
    const Transition& original = *originals[i % originals.size()];
    pool.push_back(i < originals.size() ? original : vary(original, mirrored, random));
  }
}

}  // namespace

TrainingCorpora make_training_corpora(const std::optional<std::filesystem::path>& recording, std::uint64_t seed) {
  const std::vector<std::string> names = corpus_aus();
  TrainingCorpora corpora{names,
                          {names, kCorpusRateHz, {}},
                          perform_expressions(names, {seed, kShippedPerformances.variants}),
                          {names, kCorpusRateHz, {}}};
  if (recording) append(corpora.recorded, cut_transitions(motion_of(load_au_recording(*recording))));
  for (std::uint64_t take = 0; take < kMotionTakes; ++take) {
    AuSeries series = perform_range_of_motion(names, shipped_dynamics(), kMotionSeconds, seed * 1000 + take);
    append(corpora.motions,
           cut_transitions(motion_of(record_of(fmt::format("motion-{}", take), std::move(series), kMotionRateHz))));
  }
  return corpora;
}

std::vector<Transition> make_training_pool(const TrainingCorpora& corpora, std::size_t count, double recorded_share,
                                           std::uint64_t seed) {
  Random random(seed, 23);
  std::vector<Transition> pool;
  if (corpora.recorded.transitions.empty()) recorded_share = 0;
  const auto recorded = static_cast<std::size_t>(recorded_share * static_cast<double>(count));
  add_variations(corpora.recorded, recorded, random, pool);
  add_variations(corpora.expressions, 2 * (count - recorded) / 5, random, pool);
  add_variations(corpora.motions, count - pool.size(), random, pool);
  return pool;
}

}  // namespace risorius
