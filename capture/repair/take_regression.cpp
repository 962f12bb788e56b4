#include "capture/repair/take_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace risorius {
namespace {

/// Features are smoothed by a Gaussian of this width, measured samples only: their noise would be taken for motion.
constexpr double kSmoothingS = 0.03;
constexpr std::size_t kWidestSmoothing = 40;  ///< frames to either side
/// Samples that a gap is learnt from: evenly from the whole take, and to either side of it the next ones, then ever
/// wider apart.
constexpr std::size_t kFarSamples = 180;
constexpr std::size_t kNextSamples = 10;
constexpr std::size_t kNearSamples = 22;
constexpr double kWidening = 1.25;
constexpr double kNormalMedian = 0.6745;
/// Markers near the one that is hidden say more of it than far ones: a map of all would have to learn that. Far ones
/// still count as much as kFarWeight.
constexpr double kReachMm = 40;
constexpr double kFarWeight = 0.2;
/// What is believed of known modes: their standard deviation in a take, and of what they do not explain, per axis.
constexpr double kModeStrength = 0.2, kUnknownMm = 1;

std::vector<std::size_t> frames_of(const Gap& gap) {
  std::vector<std::size_t> frames(gap.length());
  std::iota(frames.begin(), frames.end(), gap.begin);
  return frames;
}

}  // namespace

TakeRegression::TakeRegression(const HeadTake& take, const std::vector<std::string>& names,
                               const std::shared_ptr<const KnownMotion>& known)
    : take_(take), mean_mm_(take.markers, Eigen::Vector3d::Zero()), seen_in_(take.markers) {
  modes_.use(known, names);
  feature_mm_.setZero(static_cast<Eigen::Index>(3 * take.markers), static_cast<Eigen::Index>(take.frames));
  for (std::size_t i = 0; i < take.markers; ++i) {
    for (std::size_t f = 0; f < take.frames; ++f) {
      if (take.measured[take.at(f, i)]) seen_in_[i].push_back(f);
    }
    if (seen_in_[i].empty()) continue;
    smooth(i);
    bridge(i);
    modes_.see(i, mean_mm_[i]);
  }
  modes_.align();
}

void TakeRegression::smooth(std::size_t i) {
  const auto row = static_cast<Eigen::Index>(3 * i);
  Eigen::Vector3d& mean = mean_mm_[i];
  for (const std::size_t f : seen_in_[i]) mean += take_.position_mm[take_.at(f, i)];
  mean /= static_cast<double>(seen_in_[i].size());
  for (const std::size_t f : seen_in_[i]) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weight = 0;
    const std::size_t first = f - std::min(f, kWidestSmoothing);
    const std::size_t last = std::min(f + kWidestSmoothing, take_.frames - 1);
    for (std::size_t g = first; g <= last; ++g) {
      const double apart = (take_.time_s[g] - take_.time_s[f]) / kSmoothingS;
      if (apart < -3 || !take_.measured[take_.at(g, i)]) continue;
      if (apart > 3) break;
      const double w = std::exp(-apart * apart / 2);
      sum += w * take_.position_mm[take_.at(g, i)];
      weight += w;
    }
    feature_mm_.block<3, 1>(row, static_cast<Eigen::Index>(f)) = sum / weight - mean;
  }
}

/// Straight where it is hidden: a first word, for the samples of others.
void TakeRegression::bridge(std::size_t i) {
  auto way = feature_mm_.middleRows<3>(static_cast<Eigen::Index>(3 * i));
  const auto column = [](std::size_t f) { return static_cast<Eigen::Index>(f); };
  const std::vector<std::size_t>& seen = seen_in_[i];
  for (std::size_t f = 0; f < seen.front(); ++f) way.col(column(f)) = way.col(column(seen.front()));
  for (std::size_t f = seen.back() + 1; f < take_.frames; ++f) way.col(column(f)) = way.col(column(seen.back()));
  for (std::size_t k = 1; k < seen.size(); ++k) {
    const std::size_t from = seen[k - 1], to = seen[k];
    for (std::size_t f = from + 1; f < to; ++f) {
      const double share = static_cast<double>(f - from) / static_cast<double>(to - from);
      way.col(column(f)) = (1 - share) * way.col(column(from)) + share * way.col(column(to));
    }
  }
}

/// From second differences, whose median the motion hardly touches.
double TakeRegression::noise_mm(std::size_t i) const {
  std::vector<double> bends;
  for (std::size_t f = 2; f < take_.frames; ++f) {
    if (!take_.measured[take_.at(f - 2, i)] || !take_.measured[take_.at(f - 1, i)] || !take_.measured[take_.at(f, i)]) {
      continue;
    }
    const Eigen::Vector3d bend = take_.position_mm[take_.at(f, i)] - 2 * take_.position_mm[take_.at(f - 1, i)] +
                                 take_.position_mm[take_.at(f - 2, i)];
    for (int axis = 0; axis < 3; ++axis) bends.push_back(std::abs(bend[axis]));
  }
  if (bends.empty()) return 0;
  const auto middle = bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2);
  std::nth_element(bends.begin(), middle, bends.end());
  return *middle / (kNormalMedian * std::sqrt(6.0));
}

double TakeRegression::seen_share(std::size_t j, const Gap& gap) const {
  double seen = 0;
  for (std::size_t f = gap.begin; f < gap.end; ++f) seen += take_.measured[take_.at(f, j)];
  return seen / static_cast<double>(gap.length());
}

double TakeRegression::nearness(std::size_t i, std::size_t j) const {
  const double apart = (mean_mm_[i] - mean_mm_[j]).norm() / kReachMm;
  return std::exp(-apart * apart / 2);
}

double TakeRegression::unheard(const Gap& gap) const {
  double hidden = 0, all = 0;
  for (std::size_t j = 0; j < take_.markers; ++j) {
    if (j == gap.marker || seen_in_[j].empty()) continue;
    const double near = nearness(gap.marker, j);
    hidden += near * (1 - seen_share(j, gap));
    all += near;
  }
  return all > 0 ? hidden / all : 1;
}

double TakeRegression::liveliness(const Gap& gap, std::size_t begin) const {
  const Eigen::VectorXd weight = weights(gap);
  const auto from = static_cast<Eigen::Index>(begin), length = static_cast<Eigen::Index>(gap.length());
  double squared = 0;
  for (Eigen::Index j = 0; j < weight.size(); ++j) {
    if (weight[j] == 0) continue;
    const auto way = feature_mm_.block(3 * j, from, 3, length);
    const Eigen::Vector3d first = way.col(0), last = way.col(length - 1);
    for (Eigen::Index k = 1; k + 1 < length; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(length - 1);
      squared += weight[j] * (way.col(k) - (1 - share) * first - share * last).squaredNorm();
    }
  }
  return squared / static_cast<double>(length);
}

/// A marker counts as far as it is seen in the gap (what stands there instead is only a guess), and the more the
/// nearer.
Eigen::VectorXd TakeRegression::weights(const Gap& gap) const {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(take_.markers));
  for (std::size_t j = 0; j < take_.markers; ++j) {
    if (j == gap.marker) continue;
    const double seen = seen_share(j, gap);
    const double near = kFarWeight + (1 - kFarWeight) * nearness(gap.marker, j);
    weights[static_cast<Eigen::Index>(j)] = near * seen * seen * seen * seen;
  }
  return weights;
}

/// None within the gap, though the marker may be measured there (fill_at).
std::vector<std::size_t> TakeRegression::samples(const Gap& gap) const {
  const std::vector<std::size_t>& seen = seen_in_[gap.marker];
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(kFarSamples, seen.size()); ++k) {
    chosen.push_back(seen[k * seen.size() / std::min(kFarSamples, seen.size())]);
  }
  std::erase_if(chosen, [&](std::size_t f) { return f >= gap.begin && f < gap.end; });
  const auto after = static_cast<std::size_t>(std::lower_bound(seen.begin(), seen.end(), gap.end) - seen.begin());
  const auto before = static_cast<std::size_t>(std::lower_bound(seen.begin(), seen.end(), gap.begin) - seen.begin());
  double step = 0;
  for (std::size_t k = 0; k < kNearSamples; ++k) {
    step = k < kNextSamples ? static_cast<double>(k) : kWidening * step;
    const auto away = static_cast<std::size_t>(step);
    if (after + away < seen.size()) chosen.push_back(seen[after + away]);
    if (away < before) chosen.push_back(seen[before - 1 - away]);
  }
  std::ranges::sort(chosen);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

/// What the known modes make of the other markers' motion, as a map of it: each mode is a priori N(0, kModeStrength^2),
/// each coordinate kUnknownMm off, the more the less a marker counts. No columns if nothing is known of marker i.
Eigen::Matrix3Xd TakeRegression::guess_of(std::size_t i, const Eigen::VectorXd& weights) const {
  if (!modes_.knows(i)) return {};
  const auto count = weights.size();
  Eigen::MatrixXd weighted = Eigen::MatrixXd::Zero(modes_.count(), 3 * count);
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(modes_.count(), modes_.count());
  precision.diagonal().setConstant(1 / (kModeStrength * kModeStrength));
  for (Eigen::Index j = 0; j < count; ++j) {
    if (!modes_.knows(static_cast<std::size_t>(j))) continue;
    const auto modes = modes_.of(static_cast<std::size_t>(j));
    weighted.middleCols<3>(3 * j) = weights[j] / (kUnknownMm * kUnknownMm) * modes;
    precision += weighted.middleCols<3>(3 * j) * modes.transpose();
  }
  return modes_.of(i).transpose() * precision.llt().solve(weighted);
}

GapFeatures TakeRegression::features(const std::vector<std::size_t>& frames, const Eigen::VectorXd& weights,
                                     const Eigen::Matrix3Xd& guess) const {
  const auto count = static_cast<Eigen::Index>(frames.size());
  GapFeatures features{Eigen::MatrixXd(feature_mm_.rows(), count), Eigen::VectorXd(count), {}};
  Eigen::VectorXd by_axis(feature_mm_.rows());
  for (Eigen::Index j = 0; j < weights.size(); ++j) by_axis.segment<3>(3 * j).setConstant(weights[j]);
  if (guess.cols() > 0) features.guess_mm.resize(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t f = frames[static_cast<std::size_t>(k)];
    const auto column = feature_mm_.col(static_cast<Eigen::Index>(f));
    features.others.col(k) = by_axis.cwiseProduct(column);
    features.time_s[k] = take_.time_s[f];
    if (guess.cols() > 0) features.guess_mm.col(k) = guess * column;
  }
  return features;
}

Eigen::Matrix3Xd TakeRegression::positions_mm(std::size_t i, const std::vector<std::size_t>& frames) const {
  Eigen::Matrix3Xd position_mm(3, static_cast<Eigen::Index>(frames.size()));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    position_mm.col(static_cast<Eigen::Index>(k)) = take_.position_mm[take_.at(frames[k], i)];
  }
  return position_mm;
}

TakeRegression::Way TakeRegression::fill(const Gap& gap) const {
  const Eigen::VectorXd weight = weights(gap);
  const Eigen::Matrix3Xd guess = guess_of(gap.marker, weight);
  const std::vector<std::size_t> known = samples(gap);
  const GapRegression regression(features(known, weight, guess), positions_mm(gap.marker, known), noise_mm(gap.marker));
  return {regression.fill(features(frames_of(gap), weight, guess)), regression.choice()};
}

GapRegression::Fill TakeRegression::fill_at(const Gap& gap, std::size_t begin, const GapChoice& choice) const {
  const Eigen::VectorXd weight = weights(gap);
  const Eigen::Matrix3Xd guess = guess_of(gap.marker, weight);
  const Gap moved{gap.marker, begin, begin + gap.length()};
  const std::vector<std::size_t> known = samples(moved);
  const GapRegression regression(features(known, weight, guess), positions_mm(gap.marker, known), noise_mm(gap.marker),
                                 choice);
  return regression.fill(features(frames_of(moved), weight, guess));
}

}  // namespace risorius
