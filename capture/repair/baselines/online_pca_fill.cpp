#include "capture/repair/baselines/online_pca_fill.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "capture/repair/frame_clock.h"
#include "capture/repair/head_frame.h"
#include "capture/repair/position_vector.h"

namespace risorius {
namespace {

class OnlinePca {
 public:
  OnlinePca(std::size_t markers, const OnlinePcaOptions& options)
      : options_(options), size_(static_cast<Eigen::Index>(3 * markers)) {
    mean_mm_.setZero(size_);
    squares_mm2_.setZero(size_, size_);
    loadings_.setZero(size_, 0);
  }

  /// The hidden entries of `row` are replaced by what the visible ones say.
  void complete(Eigen::VectorXd& row, const std::vector<std::uint8_t>& is_visible) const {
    const Eigen::Index rank = loadings_.cols();
    Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(rank, rank);
    Eigen::VectorXd information = Eigen::VectorXd::Zero(rank);
    for (std::size_t i = 0; i < is_visible.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      if (!is_visible[i]) continue;
      const auto w = loadings_.middleRows<3>(at);
      precision += w.transpose() * w / noise_mm2_;
      information += w.transpose() * (row.segment<3>(at) - mean_mm_.segment<3>(at)) / noise_mm2_;
    }
    const Eigen::VectorXd z = precision.llt().solve(information);
    for (std::size_t i = 0; i < is_visible.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      if (!is_visible[i]) row.segment<3>(at) = mean_mm_.segment<3>(at) + loadings_.middleRows<3>(at) * z;
    }
  }

  void learn(const Eigen::VectorXd& row) {
    count_ += 1;
    const Eigen::VectorXd before = row - mean_mm_;
    mean_mm_ += before / count_;
    squares_mm2_ += before * (row - mean_mm_).transpose();
    if (static_cast<int>(count_) % options_.renew_every_frames == 0) renew();
  }

 private:
  void renew() {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(squares_mm2_ / count_);
    const Eigen::Index rank = std::min<Eigen::Index>(options_.components, size_);
    const Eigen::VectorXd energy = eigen.eigenvalues().cwiseMax(0);
    loadings_ = eigen.eigenvectors().rightCols(rank) * energy.tail(rank).cwiseSqrt().asDiagonal();
    noise_mm2_ = std::max(energy.head(size_ - rank).sum() / static_cast<double>(size_), 1e-4);
  }

  OnlinePcaOptions options_;
  Eigen::Index size_;
  double count_ = 0, noise_mm2_ = 1;
  Eigen::VectorXd mean_mm_;
  Eigen::MatrixXd squares_mm2_, loadings_;
};

}  // namespace

void fill_online_pca(std::vector<MarkerFrame>& frames, const MarkerSet& set, std::int64_t max_gap_ns,
                     const OnlinePcaOptions& options) {
  const std::size_t count = set.names.size();
  HeadFrame head;
  head.use_names(set.names);
  OnlinePca pca(count, options);
  FrameClock clock;
  clock.reset(set.rate_hz);
  std::vector<double> gap_s(count, 1e30);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * count));
  for (MarkerFrame& frame : frames) {
    const double step_s = clock.advance(frame.header.capture_time_ns);
    if (!head.process(frame)) continue;
    const std::vector<std::uint8_t>& measured = head.measured();
    for (std::size_t i = 0; i < count; ++i) {
      if (measured[i]) row.segment<3>(static_cast<Eigen::Index>(3 * i)) = head.position_head_mm()[i];
      gap_s[i] = measured[i] ? 0 : gap_s[i] + step_s;
    }
    pca.complete(row, measured);
    for (std::size_t i = 0; i < count; ++i) {
      if (measured[i] || gap_s[i] * 1e9 > static_cast<double>(max_gap_ns) + 500) continue;
      frame.position_mm[i] =
          to_position(head.head_from_world().inverse() * row.segment<3>(static_cast<Eigen::Index>(3 * i)));
      frame.standard_deviation_mm[i] = 0;
      frame.state[i] = MarkerState::kFilled;
    }
    head.learn(step_s, measured);
    pca.learn(row);
  }
}

}  // namespace risorius
