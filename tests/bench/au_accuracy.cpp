#include "bench/au_accuracy.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace risorius::bench {
namespace {

constexpr double kTieCosine = 0.95;
constexpr double kNoiseMultiple = 3;
constexpr double kLeastMotion = 0.03;  // standard deviation below which a channel has no course to compare
constexpr Eigen::Index kLongestLag = 12;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The AU fields without what a motion of the head explains: 3M x K.
Eigen::MatrixXd fields_without_head(const Rig& rig) {
  const Eigen::Index markers = rig.neutral_mm.cols();
  Eigen::MatrixXd fields(3 * markers, static_cast<Eigen::Index>(rig.au_count()));
  for (Eigen::Index k = 0; k < fields.cols(); ++k) {
    fields.col(k) = rig.aus[static_cast<std::size_t>(k)].displacement_mm.reshaped();
  }
  Eigen::MatrixXd head(3 * markers, 6);
  const Eigen::Vector3d centre = rig.neutral_mm.rowwise().mean();
  for (Eigen::Index m = 0; m < markers; ++m) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      head.block<3, 1>(3 * m, axis) = Eigen::Vector3d::Unit(axis);
      head.block<3, 1>(3 * m, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(rig.neutral_mm.col(m) - centre);
    }
  }
  return fields - head * head.colPivHouseholderQr().solve(fields);
}

double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  const double size = x.norm() * y.norm();
  return size > 0 ? x.dot(y) / size : 0;
}

/// By how many frames `solved` comes after `truth`: where their correlation is largest, by a parabola through three.
double lag_frames(const Eigen::VectorXd& truth, const Eigen::VectorXd& solved) {
  const Eigen::Index length = truth.size() - 2 * kLongestLag;
  if (length < 2) return kNan;
  std::vector<double> at;
  for (Eigen::Index lag = -kLongestLag; lag <= kLongestLag; ++lag) {
    at.push_back(correlation(truth.segment(kLongestLag, length), solved.segment(kLongestLag + lag, length)));
  }
  const auto best = std::max_element(at.begin(), at.end()) - at.begin();
  if (best == 0 || best == 2 * kLongestLag) return static_cast<double>(best - kLongestLag);
  const double before = at[static_cast<std::size_t>(best) - 1], peak = at[static_cast<std::size_t>(best)],
               after = at[static_cast<std::size_t>(best) + 1];
  return static_cast<double>(best - kLongestLag) + 0.5 * (before - after) / (before - 2 * peak + after);
}

}  // namespace

std::vector<AuTie> identifiable_aus(const Rig& rig, double noise_mm) {
  const Eigen::MatrixXd fields = fields_without_head(rig);
  std::vector<AuTie> ties;
  for (Eigen::Index k = 0; k < fields.cols(); ++k) {
    const RigAu& au = rig.aus[static_cast<std::size_t>(k)];
    if (au.displacement_mm.colwise().norm().maxCoeff() <= kNoiseMultiple * noise_mm) continue;
    const auto resembles = [&](const AuTie& tie) {
      return std::any_of(tie.aus.begin(), tie.aus.end(), [&](Eigen::Index other) {
        return fields.col(k).dot(fields.col(other)) > kTieCosine * fields.col(k).norm() * fields.col(other).norm();
      });
    };
    const auto tie = std::find_if(ties.begin(), ties.end(), resembles);
    if (tie == ties.end()) {
      ties.push_back({au.name, {k}, {}});
    } else {
      tie->name += "+" + au.name;
      tie->aus.push_back(k);
    }
  }
  for (AuTie& tie : ties) {
    double sum = 0;
    for (const Eigen::Index k : tie.aus) sum += fields.col(k).norm();
    for (const Eigen::Index k : tie.aus) tie.share.push_back(fields.col(k).norm() / sum);
  }
  return ties;
}

Eigen::MatrixXd tied_series(const Eigen::MatrixXd& aus, const std::vector<AuTie>& ties) {
  Eigen::MatrixXd series = Eigen::MatrixXd::Zero(aus.rows(), static_cast<Eigen::Index>(ties.size()));
  for (std::size_t i = 0; i < ties.size(); ++i) {
    for (std::size_t j = 0; j < ties[i].aus.size(); ++j) {
      series.col(static_cast<Eigen::Index>(i)) += ties[i].share[j] * aus.col(ties[i].aus[j]);
    }
  }
  return series;
}

AuAccuracy accuracy_of(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& solved) {
  const Eigen::Index channels = truth.cols();
  AuAccuracy accuracy;
  accuracy.rmse = ((solved - truth).colwise().squaredNorm() / static_cast<double>(truth.rows())).cwiseSqrt();
  accuracy.correlation = accuracy.lag_frames = Eigen::VectorXd::Constant(channels, kNan);
  for (Eigen::Index i = 0; i < channels; ++i) {
    const Eigen::VectorXd moves = truth.col(i).array() - truth.col(i).mean();
    if (moves.norm() < kLeastMotion * std::sqrt(static_cast<double>(truth.rows()))) continue;
    accuracy.correlation[i] = correlation(truth.col(i), solved.col(i));
    accuracy.lag_frames[i] = lag_frames(truth.col(i), solved.col(i));
  }
  std::vector<double> of_moving;
  for (Eigen::Index i = 0; i < channels; ++i) {
    if (std::isfinite(accuracy.correlation[i])) of_moving.push_back(accuracy.rmse[i]);
  }
  accuracy.moving_rmse_median = quantile(of_moving, 0.5);
  const auto quantile_of = [](const Eigen::VectorXd& v, double share) {
    return quantile(std::vector<double>(v.begin(), v.end()), share);
  };
  accuracy.rmse_median = quantile_of(accuracy.rmse, 0.5);
  accuracy.rmse_p90 = quantile_of(accuracy.rmse, 0.9);
  accuracy.rmse_all = std::sqrt(accuracy.rmse.squaredNorm() / static_cast<double>(channels));
  accuracy.correlation_median = quantile_of(accuracy.correlation, 0.5);
  accuracy.lag_median_frames = quantile_of(accuracy.lag_frames, 0.5);
  Eigen::MatrixXd moments = truth.transpose() * truth;
  moments.diagonal().array() += 1e-3 * static_cast<double>(truth.rows());  // a channel that rests explains nothing
  accuracy.crosstalk = moments.llt().solve(truth.transpose() * solved);
  return accuracy;
}

double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return kNan;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace risorius::bench
