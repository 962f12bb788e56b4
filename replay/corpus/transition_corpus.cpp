#include "replay/corpus/transition_corpus.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "replay/takes/au_column.h"

namespace risorius {
namespace {

void require(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(fmt::format("StillnessOptions.{} {} is not in [{}, {}]", name, value, least, most));
}

void check(const StillnessOptions& options) {
  require("most_speed", options.most_speed, 1e-6, 10);
  require("window_s", options.window_s, 1e-3, 10);
  require("least_still_s", options.least_still_s, 0, 10);
  require("least_change", options.least_change, 1e-6, 1);
  require("least_frames", static_cast<double>(options.least_frames), 1, 1e6);
  require("most_frames", static_cast<double>(options.most_frames), static_cast<double>(options.least_frames), 1e6);
}

/// Columns that count: a blink is no change of expression.
std::vector<Eigen::Index> columns_but_lids(const std::vector<std::string>& names) {
  std::vector<Eigen::Index> columns;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const int number = parse_au_column(names[k]).number;
    if (number != 43 && number != 45) columns.push_back(static_cast<Eigen::Index>(k));
  }
  return columns;
}

/// Every fifth block is the test's, the one two later validation's.
CorpusPart part_of_block(std::size_t block) {
  return block % 5 == 2 ? CorpusPart::kTest : block % 5 == 4 ? CorpusPart::kValidation : CorpusPart::kTrain;
}

}  // namespace

std::vector<bool> still_frames(const AuMotion& motion, const StillnessOptions& options) {
  check(options);
  const std::vector<Eigen::Index> columns = columns_but_lids(motion.names);
  const auto half = std::max<Eigen::Index>(1, std::llround(options.window_s * motion.rate_hz / 2));
  const Eigen::Index frames = motion.rows.rows();
  std::vector<bool> still(static_cast<std::size_t>(frames), false);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Index before = std::max<Eigen::Index>(f - half, 0), after = std::min(f + half, frames - 1);
    if (before == after) continue;
    float change = 0;
    for (const Eigen::Index k : columns)
      change = std::max(change, std::abs(motion.rows(after, k) - motion.rows(before, k)));
    still[static_cast<std::size_t>(f)] =
        static_cast<double>(change) * motion.rate_hz / static_cast<double>(after - before) <= options.most_speed;
  }
  // Rests too short to be a pose.
  const auto least = static_cast<std::ptrdiff_t>(std::ceil(options.least_still_s * motion.rate_hz));
  for (auto from = std::find(still.begin(), still.end(), true); from != still.end();) {
    const auto to = std::find(from, still.end(), false);
    if (to - from < least) std::fill(from, to, false);
    from = std::find(to, still.end(), true);
  }
  return still;
}

TransitionCorpus cut_transitions(const AuMotion& motion, const StillnessOptions& options, double block_s) {
  if (!(block_s > 0)) throw std::invalid_argument("cut_transitions: block_s is not above 0");
  TransitionCorpus corpus{motion.names, motion.rate_hz, {}};
  const std::vector<Eigen::Index> columns = columns_but_lids(motion.names);
  const std::vector<bool> still = still_frames(motion, options);
  const auto frames = static_cast<Eigen::Index>(still.size());
  for (Eigen::Index begin = 0, end = 0; begin < frames; begin = end) {
    // begin: the last still frame; end: the first of the next rest.
    while (begin < frames && !(still[static_cast<std::size_t>(begin)] && begin + 1 < frames &&
                               !still[static_cast<std::size_t>(begin + 1)]))
      ++begin;
    end = begin + 1;
    while (end < frames && !still[static_cast<std::size_t>(end)]) ++end;
    if (end >= frames) break;
    const Eigen::Index count = end - begin;
    if (count < options.least_frames || count > options.most_frames || begin + 1 < kTransitionPastFrames) continue;
    float change = 0;
    for (const Eigen::Index k : columns)
      change = std::max(change, std::abs(motion.rows(end, k) - motion.rows(begin, k)));
    if (static_cast<double>(change) < options.least_change) continue;
    Transition& one = corpus.transitions.emplace_back();
    one.take = motion.take;
    one.begin_s = static_cast<double>(begin) / motion.rate_hz;
    one.variant = corpus.transitions.size() - 1;
    const auto block = static_cast<std::size_t>(one.begin_s / block_s);
    one.sibling = fmt::format("{}/{}", motion.take, block);
    one.part = part_of_block(block);
    one.past = motion.rows.middleRows(begin + 1 - kTransitionPastFrames, kTransitionPastFrames);
    one.course = motion.rows.middleRows(begin + 1, count);
    one.stray = stray_of(motion.names, motion.rows.row(begin), one.course);
  }
  return corpus;
}

float stray_of(const std::vector<std::string>& names, const Eigen::RowVectorXf& start, const AuMatrix& course) {
  float stray = 0;
  for (const Eigen::Index k : columns_but_lids(names)) {
    const float end = course(course.rows() - 1, k);
    stray = std::max({stray, course.col(k).maxCoeff() - std::max(start(k), end),
                      std::min(start(k), end) - course.col(k).minCoeff()});
  }
  return stray;
}

void append(TransitionCorpus& to, const TransitionCorpus& from) {
  if (to.rate_hz != from.rate_hz) throw std::invalid_argument("append: the corpora have different rates");
  std::vector<std::vector<std::size_t>> columns;
  for (const std::string& name : to.names) columns.push_back(columns_for(from.names, name));
  const auto mapped = [&](const AuMatrix& rows) {
    AuMatrix result = AuMatrix::Zero(rows.rows(), static_cast<Eigen::Index>(to.names.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      for (const std::size_t column : columns[k])
        result.col(static_cast<Eigen::Index>(k)) +=
            rows.col(static_cast<Eigen::Index>(column)) / static_cast<float>(columns[k].size());
    }
    return result;
  };
  for (const Transition& one : from.transitions) {
    Transition& copy = to.transitions.emplace_back(one);
    copy.past = mapped(one.past);
    copy.course = mapped(one.course);
  }
}

std::vector<const Transition*> part_of(const TransitionCorpus& corpus, CorpusPart part) {
  std::vector<const Transition*> result;
  for (const Transition& one : corpus.transitions) {
    if (one.part == part) result.push_back(&one);
  }
  return result;
}

}  // namespace risorius
