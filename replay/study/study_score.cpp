#include "replay/study/study_score.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "capture/errors.h"
#include "replay/takes/csv_text.h"

namespace risorius {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr const char* kReal = "real";
constexpr const char* kUntouched = "give the file as the page handed it out";

/// Columns of the page's CSV, in any order.
struct Columns {
  explicit Columns(const CsvFile& file, const std::filesystem::path& path) {
    const std::array<std::pair<std::size_t Columns::*, const char*>, 10> wanted{{
        {&Columns::page, "page"},
        {&Columns::seed, "seed"},
        {&Columns::participant, "participant"},
        {&Columns::pair, "pair"},
        {&Columns::transition, "transition"},
        {&Columns::left, "left"},
        {&Columns::right, "right"},
        {&Columns::answer, "answer"},
        {&Columns::seconds, "seconds"},
        {&Columns::replays, "replays"},
    }};
    for (const auto& [column, name] : wanted) {
      const auto found = std::find(file.columns().begin(), file.columns().end(), name);
      if (found == file.columns().end())
        throw UserError(path.string() + ", line 1", fmt::format("there is no column {}", name), kUntouched);
      if (std::find(found + 1, file.columns().end(), name) != file.columns().end())
        throw UserError(path.string() + ", line 1", fmt::format("column {} stands twice", name), kUntouched);
      this->*column = static_cast<std::size_t>(found - file.columns().begin());
    }
  }
  std::size_t page, seed, participant, pair, transition, left, right, answer, seconds, replays;
};

std::uint64_t whole_of(const CsvFile& file, std::size_t column, const std::string& remedy) {
  const std::string_view cell = file.cell(column);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || end != cell.data() + cell.size() || cell.empty())
    file.fail_at(column, fmt::format("'{}' is no whole number", shown(cell)), remedy);
  return number;
}

std::string name_of(const CsvFile& file, std::size_t column) {
  if (file.cell(column).empty()) file.fail_at(column, "is empty", kUntouched);
  return std::string(file.cell(column));
}

StudyAnswer answer_of(const CsvFile& file, const Columns& columns) {
  StudyAnswer answer;
  answer.page = name_of(file, columns.page);
  answer.participant = name_of(file, columns.participant);
  answer.transition = name_of(file, columns.transition);
  answer.left = name_of(file, columns.left);
  answer.right = name_of(file, columns.right);
  if (answer.left == answer.right)
    file.fail_at(columns.right, fmt::format("'{}' is on both sides", shown(answer.right)), kUntouched);
  answer.seed = whole_of(file, columns.seed, kUntouched);
  answer.pair = whole_of(file, columns.pair, "pairs are numbered from 1");
  if (answer.pair == 0) file.fail_at(columns.pair, "'0' is no pair", "pairs are numbered from 1");
  answer.replays = whole_of(file, columns.replays, "0 where the pair was played once");
  const std::string_view choice = file.cell(columns.answer);
  if (choice != "left" && choice != "right" && choice != "same")
    file.fail_at(columns.answer, fmt::format("'{}' is no answer", shown(choice)), "an answer is left, right or same");
  answer.choice = choice == "left" ? StudyChoice::kLeft : choice == "right" ? StudyChoice::kRight : StudyChoice::kSame;
  const auto seconds = parse_double(file.cell(columns.seconds));
  if (!seconds || !(*seconds >= 0))
    file.fail_at(columns.seconds, fmt::format("'{}' is no time", shown(file.cell(columns.seconds))),
                 "seconds from 0, with a decimal point");
  answer.seconds = *seconds;
  return answer;
}

/// What was said before of a page's pair, and where.
struct Seen {
  std::map<std::tuple<std::string, std::string, std::uint64_t>, std::string> answered;
  struct Pair {
    std::string what, place;
  };
  std::map<std::pair<std::string, std::uint64_t>, Pair> pairs;
};

void check_against(const StudyAnswer& answer, const std::string& place, Seen& seen) {
  const auto [answered, is_new] = seen.answered.try_emplace({answer.page, answer.participant, answer.pair}, place);
  if (!is_new) {
    throw UserError(place,
                    fmt::format("pair {} of page {} was answered by {} already ({})", answer.pair, shown(answer.page),
                                shown(answer.participant), answered->second),
                    "give each participant's answers once, and each participant a code of his own");
  }
  const std::string what = fmt::format("{}: {}, {}; seed {}", shown(answer.transition), shown(answer.left),
                                       shown(answer.right), answer.seed);
  const auto [pair, is_first] = seen.pairs.try_emplace({answer.page, answer.pair}, Seen::Pair{what, place});
  if (!is_first && pair->second.what != what) {
    throw UserError(place,
                    fmt::format("pair {} of page {} is '{}', and '{}' in {}", answer.pair, shown(answer.page), what,
                                pair->second.what, pair->second.place),
                    kUntouched);
  }
}

/// The two kinds as a ComparisonScore names them.
std::pair<std::string, std::string> kinds_of(const StudyAnswer& answer) {
  std::string first = answer.left, second = answer.right;
  if (first == kReal || (second != kReal && second < first)) std::swap(first, second);
  return {first, second};
}

/// Preferences of one participant in one comparison.
struct Tally {
  std::size_t first = 0, second = 0, ties = 0;
};

}  // namespace

std::vector<StudyAnswer> load_study_answers(std::span<const std::filesystem::path> files) {
  std::vector<StudyAnswer> answers;
  Seen seen;
  for (const std::filesystem::path& path : files) {
    CsvFile file(path);
    const Columns columns(file, path);
    const std::size_t before = answers.size();
    while (file.next_row()) {
      answers.push_back(answer_of(file, columns));
      check_against(answers.back(), file.place(), seen);
    }
    if (answers.size() == before)
      throw UserError(path.string(), "there is no answer in it", "give files of participants who answered");
  }
  return answers;
}

Interval wilson_interval(std::size_t hits, std::size_t count) noexcept {
  if (count == 0) return {};
  const auto n = static_cast<double>(count);
  const double share = static_cast<double>(hits) / n, z2 = kNormal95 * kNormal95;
  const double middle = (share + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kNormal95 * std::sqrt(share * (1 - share) / n + z2 / (4 * n * n)) / (1 + z2 / n);
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

double sign_test_p(std::size_t first, std::size_t second) noexcept {
  const auto n = static_cast<double>(first + second);
  double tail = 0;
  for (std::size_t k = 0; k <= std::min(first, second); ++k) {
    const auto hits = static_cast<double>(k);
    tail += std::exp(std::lgamma(n + 1) - std::lgamma(hits + 1) - std::lgamma(n - hits + 1) - n * std::log(2.0));
  }
  return std::min(1.0, 2 * tail);
}

std::vector<ComparisonScore> score_study(std::span<const StudyAnswer> answers) {
  std::map<std::pair<std::string, std::string>, std::map<std::string, Tally>> tallies;
  for (const StudyAnswer& answer : answers) {
    const auto kinds = kinds_of(answer);
    Tally& tally = tallies[kinds][answer.participant];
    if (answer.choice == StudyChoice::kSame) {
      ++tally.ties;
    } else {
      const std::string& preferred = answer.choice == StudyChoice::kLeft ? answer.left : answer.right;
      ++(preferred == kinds.first ? tally.first : tally.second);
    }
  }
  std::vector<ComparisonScore> scores;
  for (const auto& [kinds, by_participant] : tallies) {
    ComparisonScore& score = scores.emplace_back();
    score.first = kinds.first;
    score.second = kinds.second;
    score.participants = by_participant.size();
    std::size_t for_first = 0, for_second = 0;
    for (const auto& [participant, tally] : by_participant) {
      score.first_preferred += tally.first;
      score.second_preferred += tally.second;
      score.ties += tally.ties;
      for_first += tally.first > tally.second ? 1 : 0;
      for_second += tally.second > tally.first ? 1 : 0;
    }
    const std::size_t decided = score.first_preferred + score.second_preferred;
    score.share = decided > 0 ? static_cast<double>(score.first_preferred) / static_cast<double>(decided)
                              : std::numeric_limits<double>::quiet_NaN();
    const Interval interval = wilson_interval(score.first_preferred, decided);
    score.low = interval.low;
    score.high = interval.high;
    score.p = sign_test_p(score.first_preferred, score.second_preferred);
    score.participants_p = sign_test_p(for_first, for_second);
  }
  return scores;
}

}  // namespace risorius
