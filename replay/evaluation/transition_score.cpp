#include "replay/evaluation/transition_score.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace risorius {
namespace {

using Eigen::Index;

constexpr double kPercent = 100 / kFullRange;
constexpr double kBoundTolerance = 1e-6;

/// Row `back` rows before the last one; the first one for earlier ones.
double past_value(const AuMatrix& past, Index back, Index au) {
  return past(std::max<Index>(0, past.rows() - 1 - back), au);
}

std::vector<bool> moving(const AuMatrix& past, const AuMatrix& truth) {
  std::vector<bool> result;
  for (Index au = 0; au < truth.cols(); ++au) {
    const double low = std::min(past.col(au).minCoeff(), truth.col(au).minCoeff());
    const double high = std::max(past.col(au).maxCoeff(), truth.col(au).maxCoeff());
    result.push_back(high - low > kMovingRange);
  }
  return result;
}

double last_step(const AuMatrix& past, const AuMatrix& course, Index au) {
  const Index last = course.rows() - 1;
  return std::abs(course(last, au) - (last > 0 ? double{course(last - 1, au)} : past_value(past, 0, au)));
}

}  // namespace

SeamJump seam_jump(const AuMatrix& past, const AuMatrix& next, double rate_hz, const std::vector<bool>& counted) {
  SeamJump jump;
  double aus = 0;
  for (Index au = 0; au < next.cols(); ++au) {
    if (!counted[static_cast<std::size_t>(au)]) continue;
    const double x1 = next(0, au), x0 = past_value(past, 0, au), before1 = past_value(past, 1, au),
                 before2 = past_value(past, 2, au), before3 = past_value(past, 3, au);
    const double second = x1 - 2 * x0 + before1, second_before = x0 - 2 * before1 + before2,
                 second_before_that = before1 - 2 * before2 + before3;
    jump.value += std::abs(second);
    jump.velocity_per_s += std::abs(second - second_before) * rate_hz;
    jump.acceleration_per_s2 += std::abs(second - 2 * second_before + second_before_that) * rate_hz * rate_hz;
    ++aus;
  }
  if (aus == 0) return {};
  return {jump.value / aus, jump.velocity_per_s / aus, jump.acceleration_per_s2 / aus};
}

std::vector<double> start_jumps_percent(const AuMatrix& past, const AuMatrix& next) {
  std::vector<double> jumps;
  for (Index au = 0; au < next.cols(); ++au)
    jumps.push_back(kPercent * std::abs(next(0, au) - past_value(past, 0, au)));
  return jumps;
}

TransitionScore score_transition(const AuMatrix& past, const AuMatrix& truth, const AuMatrix& made, double rate_hz) {
  if (past.rows() < 1 || truth.rows() < 1 || truth.rows() != made.rows() || past.cols() != truth.cols() ||
      truth.cols() != made.cols() || truth.cols() < 1 || !(rate_hz > 0))
    throw std::invalid_argument("score_transition: sizes that do not fit, or no rate");
  TransitionScore score;
  const Eigen::ArrayXXd error = (made - truth).cast<double>().array();
  score.mean_squared_error = error.square().mean();
  score.mean_absolute_error = error.abs().mean();
  for (Index au = 0; au < truth.cols(); ++au) score.squared_error_by_au.push_back(error.col(au).square().mean());

  const std::vector<bool> counted = moving(past, truth);
  score.moving_aus = static_cast<int>(std::count(counted.begin(), counted.end(), true));
  score.seam = seam_jump(past, made, rate_hz, counted);
  score.truth_seam = seam_jump(past, truth, rate_hz, counted);
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  const std::vector<double> jumps = start_jumps_percent(past, made);
  score.mean_jump_percent = mean(jumps);
  score.largest_jump_percent = *std::max_element(jumps.begin(), jumps.end());
  score.truth_jump_percent = mean(start_jumps_percent(past, truth));

  const Index last = truth.rows() - 1;
  for (Index au = 0; au < truth.cols(); ++au) {
    score.end_error_percent =
        std::max(score.end_error_percent, kPercent * std::abs(double{made(last, au)} - truth(last, au)));
    score.end_step_percent =
        std::max(score.end_step_percent, kPercent * (last_step(past, made, au) - last_step(past, truth, au)));
    score.reactivation_percent =
        std::max(score.reactivation_percent, reactivation_percent(past_value(past, 0, au), made, au));
  }
  score.values_out_of_bounds = static_cast<int>(
      (made.cast<double>().array() < -kBoundTolerance || made.cast<double>().array() > kFullRange + kBoundTolerance)
          .count());
  score.conspicuousness = conspicuousness_of(past, truth, made);
  return score;
}

}  // namespace risorius
