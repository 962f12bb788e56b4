#include "replay/corpus/augmentation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace risorius {
namespace {

constexpr double kMostDeviations = 2;
constexpr double kEarliest = 0.1, kLatest = 0.7;  ///< of the way, where a transition begins under way

double drawn_factor(double deviation, Random& random) {
  return std::exp(deviation * std::clamp(random.gaussian(), -kMostDeviations, kMostDeviations));
}

/// Rows at a time between whole rows, by cubics through four of them (Catmull & Rom 1974).
Eigen::RowVectorXf row_at(const AuMatrix& rows, double at) {
  const Eigen::Index last = rows.rows() - 1;
  const auto i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::floor(at)), 0, last);
  const auto u = static_cast<float>(std::clamp(at - static_cast<double>(i), 0.0, 1.0));
  const auto a = rows.row(std::max<Eigen::Index>(i - 1, 0)), b = rows.row(i), c = rows.row(std::min(i + 1, last)),
             d = rows.row(std::min(i + 2, last));
  return b + 0.5F * u * ((c - a) + u * ((2 * a - 5 * b + 4 * c - d) + u * (3 * (b - c) + d - a)));
}

}  // namespace

Transition vary(const Transition& original, const std::vector<std::size_t>& mirrored, Random& random,
                const AugmentationOptions& options) {
  const StillnessOptions limits;
  const auto length = static_cast<double>(original.course.rows());
  const double pace = drawn_factor(options.pace, random);
  const double bend = random.uniform(-options.pace_bend, options.pace_bend);
  const double strength = drawn_factor(options.amplitude, random);
  const bool mirror = random.chance(options.mirror);
  const auto frames = std::clamp<Eigen::Index>(std::llround(length * pace), limits.least_frames, limits.most_frames);

  // One series with the past, so that the pace changes nowhere at once. Row p of it is the pose that is left.
  AuMatrix rows(original.past.rows() + original.course.rows(), original.course.cols());
  rows << original.past, original.course;
  const double p = static_cast<double>(original.past.rows()) - 1, rate = length / static_cast<double>(frames);
  const auto source = [&](Eigen::Index k) {  // row of `rows` for frame k after the pose that is left
    const double u = static_cast<double>(k) / static_cast<double>(frames);
    const double warped = u <= 0 ? u : u + bend * std::sin(std::numbers::pi * u) * std::sin(std::numbers::pi * u) * 0.5;
    return std::max(0.0, p + rate * static_cast<double>(frames) * warped);
  };
  Transition result = original;
  const auto fill = [&](AuMatrix& to, Eigen::Index first) {
    for (Eigen::Index row = 0; row < to.rows(); ++row) {
      const Eigen::RowVectorXf values = row_at(rows, source(first + row));
      for (Eigen::Index k = 0; k < to.cols(); ++k) {
        const auto column = mirror ? static_cast<Eigen::Index>(mirrored[static_cast<std::size_t>(k)]) : k;
        to(row, k) = std::clamp(static_cast<float>(strength) * values(column), 0.0F, 1.2F);
      }
    }
  };
  fill(result.past, 1 - original.past.rows());
  result.course.resize(frames, original.course.cols());
  fill(result.course, 1);
  if (!random.chance(options.under_way)) return result;
  return under_way(result, static_cast<Eigen::Index>(random.uniform(kEarliest, kLatest) * static_cast<double>(frames)));
}

Transition under_way(const Transition& whole, Eigen::Index first) {
  const Eigen::Index past = whole.past.rows();
  AuMatrix rows(past + whole.course.rows(), whole.course.cols());
  rows << whole.past, whole.course;
  Transition rest = whole;
  rest.begin_s += static_cast<double>(first) / kCorpusRateHz;
  rest.past = rows.middleRows(first, past);
  rest.course = rows.bottomRows(whole.course.rows() - first);
  return rest;
}

}  // namespace risorius
