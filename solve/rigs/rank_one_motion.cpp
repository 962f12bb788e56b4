#include "solve/rigs/rank_one_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "solve/robust_weight.h"

namespace risorius {
namespace {

constexpr int kAlternations = 15;
/// Frames between these amplitudes say what the field is: below is rest, above is another movement, too brief to last.
constexpr double kFieldShare = 0.5, kBriefShare = 1.3;
/// At both ends of a recording the face should be at rest.
constexpr double kEndShare = 0.08;
/// A recording that moves away from its ends less than this, in squares, against how far it is from the neutral, was
/// held throughout: then its ends are no rest.
constexpr double kLeastMovedShare = 0.25;
constexpr double kOutlierScales = 4;
/// Half the window of the running median: a twelfth of the recording, so that a movement held for longer than a sixth
/// of it outlasts the window.
constexpr std::size_t kFramesPerReach = 12, kLeastReach = 2, kMostReach = 60;

double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::size_t reach_of(std::size_t frames) {
  return std::clamp<std::size_t>(frames / kFramesPerReach, kLeastReach, kMostReach);
}

/// Running medians over time of the measured displacements: what lasts stays, a blink or a leap does not. Where a
/// marker is hidden throughout the window, zero.
std::vector<Eigen::Matrix3Xd> lasting_displacements(const Displacements& take) {
  const std::size_t frames = take.d_mm.size();
  const std::size_t reach = reach_of(frames);
  std::vector<Eigen::Matrix3Xd> lasting(frames, Eigen::Matrix3Xd::Zero(3, take.weight.front().size()));
  std::vector<double> window;
  for (Eigen::Index m = 0; m < take.weight.front().size(); ++m) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (std::size_t t = 0; t < frames; ++t) {
        window.clear();
        for (std::size_t k = t > reach ? t - reach : 0; k < std::min(frames, t + reach + 1); ++k) {
          if (take.weight[k][m] > 0) window.push_back(take.d_mm[k](axis, m));
        }
        if (!window.empty()) lasting[t](axis, m) = quantile(window, 0.5);
      }
    }
  }
  return lasting;
}

/// The mean of the tenth of the frames that lie farthest from the neutral and stay there.
Eigen::Matrix3Xd first_field(const Displacements& take) {
  const std::vector<Eigen::Matrix3Xd> lasting = lasting_displacements(take);
  std::vector<double> distance;
  for (const Eigen::Matrix3Xd& d_mm : lasting) distance.push_back(d_mm.squaredNorm());
  const double far = quantile(distance, 0.9);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, lasting.front().cols());
  double count = 0;
  for (std::size_t t = 0; t < distance.size(); ++t) {
    if (distance[t] < far) continue;
    sum += lasting[t];
    ++count;
  }
  return sum / count;
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

/// The median of what is held: of the frames whose amplitude is near the greatest that lasts.
double held_level(const Eigen::VectorXd& amplitude, double hold_share) {
  const std::vector<double> values(amplitude.begin(), amplitude.end());
  std::vector<double> lasting;
  for (std::size_t t = 0; t < values.size(); ++t) {
    const std::size_t reach = reach_of(values.size());
    const std::size_t first = t > reach ? t - reach : 0, last = std::min(values.size(), t + reach + 1);
    lasting.push_back(quantile(
        {values.begin() + static_cast<std::ptrdiff_t>(first), values.begin() + static_cast<std::ptrdiff_t>(last)},
        0.5));
  }
  const double greatest = *std::ranges::max_element(lasting);
  std::vector<double> held;
  for (std::size_t t = 0; t < values.size(); ++t) {
    if (lasting[t] >= hold_share * greatest) held.push_back(values[t]);
  }
  return quantile(held, 0.5);
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
    const double level = held_level(model.amplitude, hold_share);
    if (!(level > 0)) break;
    model.amplitude /= level;
    model.field_mm *= level;
    model.noise_mm = reweigh(take, model, weight);
    Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, model.field_mm.cols());
    model.evidence.setZero();
    for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
      const double a = model.amplitude[static_cast<Eigen::Index>(t)];
      if (a < kFieldShare || a > kBriefShare) continue;
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

Eigen::Matrix3Xd rest_of(const Displacements& take) {
  const std::vector<Eigen::Matrix3Xd> lasting = lasting_displacements(take);
  const auto frames = lasting.size();
  const auto end = std::max<std::size_t>(1, static_cast<std::size_t>(kEndShare * static_cast<double>(frames)));
  Eigen::Matrix3Xd rest = lasting.front();
  std::vector<double> values;
  for (Eigen::Index i = 0; i < rest.size(); ++i) {
    values.clear();
    for (std::size_t t = 0; t < end; ++t) {
      values.push_back(lasting[t](i));
      values.push_back(lasting[frames - 1 - t](i));
    }
    rest(i) = quantile(values, 0.5);
  }
  double from_rest = 0, from_neutral = 0;
  for (const Eigen::Matrix3Xd& d_mm : lasting) {
    from_rest = std::max(from_rest, (d_mm - rest).squaredNorm());
    from_neutral = std::max(from_neutral, d_mm.squaredNorm());
  }
  return from_rest >= kLeastMovedShare * from_neutral ? rest : Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(3, rest.cols()));
}

void shrink_to_evidence(RankOneMotion& model) {
  for (Eigen::Index m = 0; m < model.field_mm.cols(); ++m) {
    const double squared = model.field_mm.col(m).squaredNorm();
    const double of_noise = 3 * model.noise_mm * model.noise_mm / std::max(model.evidence[m], 1e-9);
    model.field_mm.col(m) *= squared > of_noise ? 1 - of_noise / squared : 0;
  }
}

}  // namespace risorius
