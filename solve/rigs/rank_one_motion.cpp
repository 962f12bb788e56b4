#include "solve/rigs/rank_one_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "solve/robust_weight.h"

namespace risorius {
namespace {

constexpr int kAlternations = 15;
/// Of the greatest amplitude: frames below are rest, frames above say what the field is.
constexpr double kRestShare = 0.1, kFieldShare = 0.5;
constexpr std::size_t kLeastRestFrames = 5;
constexpr double kOutlierScales = 4;

double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double quantile(const Eigen::VectorXd& values, double q) {
  return quantile(std::vector<double>(values.begin(), values.end()), q);
}

/// The mean of the tenth of the frames that lie farthest from the neutral; medians would be as good a start.
Eigen::Matrix3Xd first_field(const Displacements& take) {
  std::vector<double> distance(take.d_mm.size());
  for (std::size_t t = 0; t < distance.size(); ++t) {
    std::vector<double> squares;
    for (Eigen::Index m = 0; m < take.weight[t].size(); ++m) {
      if (take.weight[t][m] > 0) squares.push_back(take.d_mm[t].col(m).squaredNorm());
    }
    // Without the farthest marker of the frame: it may be a false one.
    std::ranges::sort(squares);
    for (std::size_t k = 0; k + 1 < squares.size(); ++k)
      distance[t] += squares[k] / static_cast<double>(squares.size());
  }
  const double far = quantile(distance, 0.9);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, take.weight.front().size());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(sum.cols());
  for (std::size_t t = 0; t < distance.size(); ++t) {
    if (distance[t] < far) continue;
    sum += take.d_mm[t] * take.weight[t].asDiagonal();
    count += take.weight[t];
  }
  return sum * count.cwiseMax(1.0).cwiseInverse().asDiagonal();
}

/// The amplitude of each frame, given field and weights.
Eigen::VectorXd amplitudes(const Displacements& take, const std::vector<Eigen::VectorXd>& weight,
                           const Eigen::Matrix3Xd& field) {
  const Eigen::VectorXd squares = field.colwise().squaredNorm();
  Eigen::VectorXd a(static_cast<Eigen::Index>(take.d_mm.size()));
  for (Eigen::Index t = 0; t < a.size(); ++t) {
    const auto i = static_cast<std::size_t>(t);
    const Eigen::VectorXd along = take.d_mm[i].cwiseProduct(field).colwise().sum();
    a[t] = weight[i].dot(along) / std::max(weight[i].dot(squares), 1e-9);
  }
  return a;
}

/// Weights fall where a marker is farther from the explanation than noise carries it. Returns that noise, per axis.
double reweigh(const Displacements& take, const RankOneMotion& model, std::vector<Eigen::VectorXd>& weight) {
  std::vector<double> distances;
  for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
    const double a = model.amplitude[static_cast<Eigen::Index>(t)];
    for (Eigen::Index m = 0; m < weight[t].size(); ++m) {
      if (take.weight[t][m] > 0) distances.push_back((take.d_mm[t].col(m) - a * model.field_mm.col(m)).norm());
    }
  }
  // The median length of a normal vector in three dimensions is 1.538 of its standard deviation per axis.
  const double noise_mm = std::max(quantile(distances, 0.5) / 1.538, 1e-6);
  const double limit_mm = kOutlierScales * noise_mm;
  for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
    const double a = model.amplitude[static_cast<Eigen::Index>(t)];
    for (Eigen::Index m = 0; m < weight[t].size(); ++m) {
      const double distance = (take.d_mm[t].col(m) - a * model.field_mm.col(m)).norm();
      weight[t][m] = take.weight[t][m] * robust_weight(distance, limit_mm, 4);
    }
  }
  return noise_mm;
}

}  // namespace

/// d_t = a_t e, robustly. Frames of small amplitude hold noise and other movements, so the field is made of the others;
/// it is normed so that its greatest held amplitude is 1.
RankOneMotion find_rank_one_motion(const Displacements& take, double hold_share) {
  RankOneMotion model;
  model.field_mm = first_field(take);
  model.evidence = Eigen::VectorXd::Zero(model.field_mm.cols());
  std::vector<Eigen::VectorXd> weight = take.weight;
  for (int round = 0; round < kAlternations; ++round) {
    model.amplitude = amplitudes(take, weight, model.field_mm);
    const double greatest = quantile(model.amplitude, 0.98);
    if (!(greatest > 0)) break;
    std::vector<double> held;
    for (const double a : model.amplitude) {
      if (a >= hold_share * greatest) held.push_back(a);
    }
    const double level = quantile(held, 0.5);
    model.amplitude /= level;
    model.field_mm *= level;
    model.noise_mm = reweigh(take, model, weight);
    Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, model.field_mm.cols());
    model.evidence.setZero();
    for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
      const double a = model.amplitude[static_cast<Eigen::Index>(t)];
      if (a < kFieldShare) continue;
      sum += take.d_mm[t] * (a * weight[t]).asDiagonal();
      model.evidence += a * a * weight[t];
    }
    for (Eigen::Index m = 0; m < sum.cols(); ++m) {
      model.field_mm.col(m) =
          model.evidence[m] > 0 ? Eigen::Vector3d(sum.col(m) / model.evidence[m]) : Eigen::Vector3d::Zero();
    }
  }
  return model;
}

Eigen::Matrix3Xd rest_of(const Displacements& take, const Eigen::VectorXd& amplitude) {
  Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, take.weight.front().size());
  for (Eigen::Index m = 0; m < rest.cols(); ++m) {
    std::array<std::vector<double>, 3> values;
    for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
      if (std::abs(amplitude[static_cast<Eigen::Index>(t)]) > kRestShare || !(take.weight[t][m] > 0)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis)
        values[axis].push_back(take.d_mm[t](static_cast<Eigen::Index>(axis), m));
    }
    if (values[0].size() < kLeastRestFrames) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) rest(static_cast<Eigen::Index>(axis), m) = quantile(values[axis], 0.5);
  }
  return rest;
}

void shrink_to_evidence(RankOneMotion& model) {
  for (Eigen::Index m = 0; m < model.field_mm.cols(); ++m) {
    const double squared = model.field_mm.col(m).squaredNorm();
    const double of_noise = 3 * model.noise_mm * model.noise_mm / std::max(model.evidence[m], 1e-9);
    model.field_mm.col(m) *= squared > of_noise ? 1 - of_noise / squared : 0;
  }
}

}  // namespace risorius
