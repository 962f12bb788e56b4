#include "replay/corpus/expression_corpus.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <stdexcept>

#include "replay/performer/au_wander.h"
#include "replay/performer/expression_table.h"
#include "replay/performer/performer_script.h"
#include "replay/takes/arkit_aus.h"

namespace risorius {
namespace {

constexpr double kSettleS = 0.25;    // after the apex: what went too far comes back within
constexpr double kLeastFrames = 41;  // seed 003's shortest and longest
constexpr double kMostFrames = 402;
constexpr double kHighestIntensity = 1.2;

/// A whole performance of both sets of expressions at the corpus's rate.
AuMatrix perform(const std::vector<std::string>& names, PerformerScript& script, std::uint64_t seed) {
  const auto frames = static_cast<Eigen::Index>(script.seconds() * kCorpusRateHz);
  AuMatrix rows(frames, static_cast<Eigen::Index>(names.size()));
  const std::vector<double> upper(names.size(), kHighestIntensity);
  AuWander wander(names.size(), shipped_dynamics().micro_motion, shipped_dynamics().rest_drift, 1, kCorpusRateHz, seed);
  std::vector<double> values(names.size());
  for (Eigen::Index f = 0; f < frames; ++f) {
    script.intensities_at(static_cast<double>(f) / kCorpusRateHz, values);
    wander.add_to(values, upper);
    for (std::size_t k = 0; k < names.size(); ++k)
      rows(f, static_cast<Eigen::Index>(k)) = static_cast<float>(values[k]);
  }
  return rows;
}

CorpusPart part_of_variant(std::size_t variant, std::size_t variants) {
  if (variants < 3) return CorpusPart::kTrain;
  return variant + 1 == variants   ? CorpusPart::kTest
         : variant + 2 == variants ? CorpusPart::kValidation
                                   : CorpusPart::kTrain;
}

}  // namespace

TransitionCorpus perform_expressions(const std::vector<std::string>& names, const ExpressionCorpusOptions& options) {
  if (options.variants < 1 || options.variants > 100)
    throw std::invalid_argument(
        fmt::format("ExpressionCorpusOptions.variants {} is not in [1, 100]", options.variants));
  TransitionCorpus corpus{names, kCorpusRateHz, {}};
  const std::vector<std::string>& six = shipped_expression_table().sets.find("seed003")->second;
  for (std::size_t variant = 0; variant < options.variants; ++variant) {
    ScriptOptions script_options;
    script_options.kind = ScriptKind::kExpressions;
    script_options.seconds = 0;
    script_options.seed = options.seed + 7919 * variant;
    PerformerScript script(names, script_options);
    const AuMatrix rows = perform(names, script, script_options.seed);
    std::map<std::string, int> seen;
    for (const ScriptCue& cue : script.cues()) {
      const std::size_t arrow = cue.what.find(" > ");
      if (arrow == std::string::npos || seen[cue.what]++ > 0) continue;
      const std::string from = cue.what.substr(0, arrow), to = cue.what.substr(arrow + 3);
      if (std::find(six.begin(), six.end(), from) == six.end() || std::find(six.begin(), six.end(), to) == six.end())
        continue;
      const auto begin = static_cast<Eigen::Index>(std::floor(cue.begin_s * kCorpusRateHz));
      const double end_s = std::min(cue.apex_s + kSettleS, cue.end_s);
      const double count = std::clamp(std::ceil((end_s - cue.begin_s) * kCorpusRateHz), kLeastFrames, kMostFrames);
      const auto frames = static_cast<Eigen::Index>(count);
      if (begin + 1 < kTransitionPastFrames || begin + frames >= rows.rows()) continue;
      Transition& one = corpus.transitions.emplace_back();
      one.take = fmt::format("performer-{}", script_options.seed);
      one.from = from;
      one.to = to;
      one.variant = variant;
      one.sibling = one.take;
      one.part = part_of_variant(variant, options.variants);
      one.begin_s = cue.begin_s;
      one.past = rows.middleRows(begin + 1 - kTransitionPastFrames, kTransitionPastFrames);
      one.course = rows.middleRows(begin + 1, frames);
      one.stray = stray_of(names, rows.row(begin), one.course);
    }
  }
  return corpus;
}

const std::vector<std::pair<std::string_view, std::string_view>>& seed003_pairs() {
  static const std::vector<std::pair<std::string_view, std::string_view>> pairs{
      {"disgusted", "happy"},  {"disgusted", "surprised"}, {"frowning", "happy"},      {"frowning", "neutral"},
      {"happy", "disgusted"},  {"happy", "frowning"},      {"happy", "neutral"},       {"happy", "sad"},
      {"happy", "surprised"},  {"neutral", "frowning"},    {"neutral", "happy"},       {"neutral", "surprised"},
      {"sad", "happy"},        {"sad", "surprised"},       {"surprised", "disgusted"}, {"surprised", "happy"},
      {"surprised", "neutral"}};
  return pairs;
}

bool is_seed003_pair(std::string_view from, std::string_view to) {
  const auto& pairs = seed003_pairs();
  return std::find(pairs.begin(), pairs.end(), std::pair(from, to)) != pairs.end();
}

TransitionCorpus only_pairs(const TransitionCorpus& corpus,
                            const std::vector<std::pair<std::string_view, std::string_view>>& pairs) {
  TransitionCorpus result{corpus.names, corpus.rate_hz, {}};
  for (const Transition& one : corpus.transitions) {
    const auto same = [&](const auto& pair) { return pair.first == one.from && pair.second == one.to; };
    if (std::any_of(pairs.begin(), pairs.end(), same)) result.transitions.push_back(one);
  }
  return result;
}

std::vector<std::string> corpus_aus() {
  std::vector<std::string> shapes;
  for (const ArkitAu& au : shipped_arkit_table().aus) {
    for (const ShapeWeights& alternative : au.read) {
      for (const auto& [shape, weight] : alternative) shapes.push_back(shape);
    }
  }
  std::sort(shapes.begin(), shapes.end());
  shapes.erase(std::unique(shapes.begin(), shapes.end()), shapes.end());
  return ArkitReader(shapes, shipped_arkit_table(), JawColumns::kWhole, true).names();
}

}  // namespace risorius
