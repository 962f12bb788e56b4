#include "replay/evaluation/conspicuousness.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace risorius {
namespace {

using Eigen::Index;

constexpr double kPercent = 100 / kFullRange;

double largest_step(double start, const AuMatrix& course, Index au) {
  double largest = 0, before = start;
  for (Index k = 0; k < course.rows(); ++k) {
    largest = std::max(largest, std::abs(course(k, au) - before));
    before = course(k, au);
  }
  return largest;
}

}  // namespace

double reactivation_percent(double start, const AuMatrix& course, Index au) {
  if (course.rows() < 1) return 0;
  const double sign = course(course.rows() - 1, au) >= start ? 1 : -1;
  double farthest = sign * start, against = 0;
  for (Index k = 0; k < course.rows(); ++k) {
    farthest = std::max(farthest, sign * course(k, au));
    against = std::max(against, farthest - sign * course(k, au));
  }
  return kPercent * against;
}

char symbol_of(TransitionRating rating) noexcept {
  return rating == TransitionRating::kInconspicuous ? '+' : rating == TransitionRating::kNarrow ? 'o' : '-';
}

std::array<double, kCriteria> Conspicuousness::excess() const noexcept {
  return {summed_error / 1, std::max(largest_jump_percent / 40, third_jump_percent / 20), reactivation_percent / 25,
          end_percent / 25};
}

bool Conspicuousness::is_conspicuous() const noexcept { return rating() != TransitionRating::kInconspicuous; }

TransitionRating Conspicuousness::rating() const noexcept {
  const std::array<double, kCriteria> all = excess();
  const auto above = std::count_if(all.begin(), all.end(), [](double one) { return one > 1; });
  if (above == 0) return TransitionRating::kInconspicuous;
  const bool is_narrow = above == 1 && *std::max_element(all.begin(), all.end()) <= kNarrowExcess;
  return is_narrow ? TransitionRating::kNarrow : TransitionRating::kConspicuous;
}

Conspicuousness conspicuousness_of(const AuMatrix& past, const AuMatrix& truth, const AuMatrix& made) {
  if (past.rows() < 1 || truth.rows() < 1 || truth.rows() != made.rows() || past.cols() != truth.cols() ||
      truth.cols() != made.cols() || truth.cols() < 1)
    throw std::invalid_argument("conspicuousness_of: sizes that do not fit");
  Conspicuousness result;
  const Index last = truth.rows() - 1;
  std::vector<double> jumps;
  for (Index au = 0; au < truth.cols(); ++au) {
    const double start = past(past.rows() - 1, au);
    result.summed_error +=
        (made.col(au) - truth.col(au)).cast<double>().squaredNorm() / static_cast<double>(truth.cols());
    jumps.push_back(kPercent * largest_step(start, made, au));
    result.reactivation_percent = std::max(
        result.reactivation_percent, reactivation_percent(start, made, au) - reactivation_percent(start, truth, au));
    const double at_start = std::abs(made(0, au) - start) - std::abs(truth(0, au) - start);
    result.end_percent = std::max(
        {result.end_percent, kPercent * at_start, kPercent * std::abs(double{made(last, au)} - truth(last, au))});
  }
  std::sort(jumps.rbegin(), jumps.rend());
  result.largest_jump_percent = jumps[0];
  if (jumps.size() >= 3) result.third_jump_percent = jumps[2];
  return result;
}

}  // namespace risorius
