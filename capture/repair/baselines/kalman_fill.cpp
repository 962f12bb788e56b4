#include "capture/repair/baselines/kalman_fill.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <numeric>

#include "capture/repair/baselines/interpolation.h"
#include "capture/repair/baselines/marker_matrix.h"

namespace risorius {
namespace {

constexpr std::size_t kLeastFrames = 10;

/// y = mean + W z + v,   z' = z + w,   v ~ N(0, noise I),   w ~ N(0, walk).
struct WalkModel {
  Eigen::RowVectorXd mean_mm;
  Eigen::MatrixXd loadings, walk;  ///< W: 3 markers x d
  Eigen::MatrixXd spread;          ///< of z at any time
  double noise_mm2 = 0;
};

WalkModel learn(const MarkerMatrix& take, const std::vector<Eigen::Index>& complete, double kept_energy) {
  Eigen::MatrixXd data(static_cast<Eigen::Index>(complete.size()), take.position_mm.cols());
  for (Eigen::Index r = 0; r < data.rows(); ++r)
    data.row(r) = take.position_mm.row(complete[static_cast<std::size_t>(r)]);
  WalkModel model;
  model.mean_mm = data.colwise().mean();
  data.rowwise() -= model.mean_mm;
  const auto count = static_cast<double>(data.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(data.transpose() * data / count);
  const Eigen::VectorXd energy = eigen.eigenvalues().cwiseMax(0);
  Eigen::Index kept = 1;
  while (kept < energy.size() && energy.tail(kept).sum() < kept_energy * energy.sum()) ++kept;
  model.loadings = eigen.eigenvectors().rightCols(kept);
  model.spread = energy.tail(kept).asDiagonal();
  model.noise_mm2 = std::max(energy.head(energy.size() - kept).sum() / static_cast<double>(energy.size()), 1e-6);
  const Eigen::MatrixXd latent = data * model.loadings;
  model.walk = 1e-9 * Eigen::MatrixXd::Identity(kept, kept);
  double steps = 0;
  for (std::size_t r = 1; r < complete.size(); ++r) {
    if (complete[r] != complete[r - 1] + 1) continue;
    const auto row = static_cast<Eigen::Index>(r);
    const Eigen::RowVectorXd step = latent.row(row) - latent.row(row - 1);
    model.walk += step.transpose() * step;
    steps += 1;
  }
  model.walk /= std::max(steps, 1.0);
  return model;
}

/// Forward filter in information form, then Rauch, Tung & Striebel backwards. Returns z, one row per frame.
Eigen::MatrixXd smooth(const MarkerMatrix& take, const WalkModel& model) {
  const Eigen::Index d = model.loadings.cols(), frames = take.frames();
  std::vector<Eigen::MatrixXd> covariance(static_cast<std::size_t>(frames));
  Eigen::MatrixXd z(frames, d);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(d);
  Eigen::MatrixXd predicted = model.spread;
  for (Eigen::Index f = 0; f < frames; ++f) {
    Eigen::MatrixXd precision = predicted.llt().solve(Eigen::MatrixXd::Identity(d, d));
    Eigen::VectorXd information = precision * state;
    for (Eigen::Index i = 0; i < take.markers(); ++i) {
      if (!take.is_seen(f, i)) continue;
      const auto w = model.loadings.middleRows<3>(3 * i);
      const Eigen::Vector3d y =
          (take.position_mm.block<1, 3>(f, 3 * i) - model.mean_mm.segment<3>(3 * i)).transpose() / model.noise_mm2;
      precision += w.transpose() * w / model.noise_mm2;
      information += w.transpose() * y;
    }
    covariance[static_cast<std::size_t>(f)] = precision.llt().solve(Eigen::MatrixXd::Identity(d, d));
    state = covariance[static_cast<std::size_t>(f)] * information;
    z.row(f) = state.transpose();
    predicted = covariance[static_cast<std::size_t>(f)] + model.walk;
  }
  for (Eigen::Index f = frames - 1; f-- > 0;) {
    const Eigen::MatrixXd& own = covariance[static_cast<std::size_t>(f)];
    const Eigen::MatrixXd gain = (own + model.walk).llt().solve(own).transpose();
    z.row(f) += (gain * (z.row(f + 1) - z.row(f)).transpose()).transpose();
  }
  return z;
}

}  // namespace

void fill_kalman(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns, const KalmanFillOptions& options) {
  const MarkerMatrix take(frames);
  std::vector<Eigen::Index> all(static_cast<std::size_t>(take.markers()));
  std::iota(all.begin(), all.end(), 0);
  const std::vector<Eigen::Index> complete = take.frames_with(all);
  if (complete.size() < kLeastFrames) {
    fill_linear(frames, max_gap_ns);
    return;
  }
  const WalkModel model = learn(take, complete, options.kept_energy);
  const Eigen::MatrixXd z = smooth(take, model);
  Eigen::MatrixXd filled_mm = z * model.loadings.transpose();
  filled_mm.rowwise() += model.mean_mm;
  write_filled(frames, take, filled_mm, max_gap_ns);
}

}  // namespace risorius
