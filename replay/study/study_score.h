// What the participants of a blind comparison answered, and what it says: how often each kind was preferred to another.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace risorius {

enum class StudyChoice : std::uint8_t { kLeft, kRight, kSame };

/// One line of the CSV that the study's page hands out (README.md, "The study's page").
struct StudyAnswer {
  std::string page, participant, transition;
  std::uint64_t seed = 0, pair = 0, replays = 0;
  std::string left, right;  ///< kinds
  StudyChoice choice = StudyChoice::kSame;
  double seconds = 0;
};

/// All files together. Throws UserError (file, line, column, value, remedy), also where one pair was answered twice by
/// one participant, and where a pair of one page is not the same pair in all lines.
std::vector<StudyAnswer> load_study_answers(std::span<const std::filesystem::path> files);

/// Of one comparison of kinds, over all answers.
struct ComparisonScore {
  std::string first, second;  ///< kinds: "real" is second, else in the order of the alphabet
  std::size_t first_preferred = 0, second_preferred = 0, ties = 0, participants = 0;
  /// Of the answers that prefer one, the share of the first; with Wilson's 95 % interval. NaN, 0 and 1 where there are
  /// none.
  double share = 0, low = 0, high = 1;
  double p = 1;  ///< two-sided sign test: both are preferred equally often; ties left out
  /// The same test over participants, each counted by which kind he preferred more often: answers of one participant
  /// are not independent.
  double participants_p = 1;
};

/// In the order of the kinds' names.
std::vector<ComparisonScore> score_study(std::span<const StudyAnswer> answers);

struct Interval {
  double low = 0, high = 1;
};
/// Wilson (1927) for a share of `hits` among `count`, at 95 %.
Interval wilson_interval(std::size_t hits, std::size_t count) noexcept;
/// Exact two-sided sign test: the chance of a split at least as uneven.
double sign_test_p(std::size_t first, std::size_t second) noexcept;

}  // namespace risorius
