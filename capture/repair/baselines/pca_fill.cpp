#include "capture/repair/baselines/pca_fill.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "capture/repair/baselines/interpolation.h"
#include "capture/repair/baselines/marker_matrix.h"

namespace risorius {
namespace {

using Indices = std::vector<Eigen::Index>;

struct Components {
  Eigen::MatrixXd directions;       ///< columns, strongest first
  Eigen::VectorXd singular_values;  ///< likewise
  Eigen::Index needed(double share) const {
    double sum = 0;
    for (Eigen::Index k = 0; k < singular_values.size(); ++k) {
      sum += singular_values[k];
      if (sum >= share * singular_values.sum()) return k + 1;
    }
    return singular_values.size();
  }
};

Components components_of(const Eigen::MatrixXd& gram) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  return {eigen.eigenvectors().rowwise().reverse(), eigen.eigenvalues().reverse().cwiseMax(0).cwiseSqrt()};
}

class PcaFiller {
 public:
  PcaFiller(const MarkerMatrix& take, const PcaFillOptions& options)
      : take_(take), options_(options), relative_mm_(take.position_mm), centre_mm_(take.frames(), 3) {
    for (Eigen::Index i = 0; i < take.markers(); ++i) {
      (take.is_seen.col(i).minCoeff() ? whole_ : gapped_).push_back(i);
    }
  }
  bool can_centre() const { return !whole_.empty(); }
  const Indices& gapped() const { return gapped_; }

  /// The mean of the markers without gaps moves with the subject.
  void centre() {
    centre_mm_.setZero();
    for (const Eigen::Index i : whole_) {
      centre_mm_ += take_.position_mm.middleCols<3>(3 * i) / static_cast<double>(whole_.size());
    }
    for (Eigen::Index i = 0; i < take_.markers(); ++i) relative_mm_.middleCols<3>(3 * i) -= centre_mm_;
  }

  /// Writes the hidden samples of marker i; false if no frame shows enough.
  bool fill(Eigen::Index i, Eigen::MatrixXd& filled_mm) const {
    const Eigen::VectorXd distance_mm = distances(i);
    Indices used = helpers(i, distance_mm);
    const auto own = static_cast<Eigen::Index>(used.size());
    used.push_back(i);
    const Indices complete = take_.frames_with(used);
    if (complete.size() < 2 || own == 0) return false;

    const Eigen::Index columns = 3 * static_cast<Eigen::Index>(used.size());
    Eigen::MatrixXd data(static_cast<Eigen::Index>(complete.size()), columns);
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(used.size()); ++k) {
      for (Eigen::Index r = 0; r < data.rows(); ++r) {
        data.block<1, 3>(r, 3 * k) =
            relative_mm_.block<1, 3>(complete[static_cast<std::size_t>(r)], 3 * used[static_cast<std::size_t>(k)]);
      }
    }
    const Eigen::RowVectorXd mean = data.colwise().mean();
    data.rowwise() -= mean;
    const Eigen::RowVectorXd deviation =
        (data.colwise().squaredNorm() / static_cast<double>(data.rows())).cwiseSqrt().cwiseMax(1e-9);
    Eigen::RowVectorXd weight(columns);
    for (Eigen::Index k = 0; k <= own; ++k) {
      const double d = distance_mm[used[static_cast<std::size_t>(k)]] / options_.weight_scale_mm;
      weight.segment<3>(3 * k).setConstant(k == own ? options_.missing_weight : std::exp(-d * d / 2));
    }
    const Eigen::RowVectorXd scale = weight.cwiseQuotient(deviation);
    data = data * scale.asDiagonal();

    Eigen::MatrixXd gram = data.transpose() * data;
    const Components with = components_of(gram);
    gram.rightCols<3>().setZero();
    gram.bottomRows<3>().setZero();
    const Components without = components_of(gram);
    const Eigen::Index kept =
        std::max(with.needed(options_.kept_singular_sum), without.needed(options_.kept_singular_sum));
    // Federolf 2013, eq. (1): from the components without the marker to those with it, and out of them the marker.
    const auto kept_with = with.directions.leftCols(kept);
    const auto kept_without = without.directions.leftCols(kept);
    const Eigen::MatrixXd predictor =
        kept_without * (kept_without.transpose() * kept_with) * kept_with.transpose().rightCols<3>();

    for (Eigen::Index f = 0; f < take_.frames(); ++f) {
      if (take_.is_seen(f, i)) continue;
      Eigen::RowVectorXd row(columns);
      for (Eigen::Index k = 0; k < own; ++k) {
        row.segment<3>(3 * k) = relative_mm_.block<1, 3>(f, 3 * used[static_cast<std::size_t>(k)]);
      }
      row.tail<3>().setZero();
      row = (row - mean).cwiseProduct(scale);
      row.tail<3>().setZero();
      const Eigen::RowVector3d predicted = (row * predictor).cwiseQuotient(scale.tail<3>()) + mean.tail<3>();
      filled_mm.block<1, 3>(f, 3 * i) = predicted + centre_mm_.row(f);
    }
    return true;
  }

 private:
  /// Mean distances from marker i over the frames in which both are seen.
  Eigen::VectorXd distances(Eigen::Index i) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(take_.markers()), count = sum;
    for (Eigen::Index f = 0; f < take_.frames(); ++f) {
      if (!take_.is_seen(f, i)) continue;
      for (Eigen::Index k = 0; k < take_.markers(); ++k) {
        if (!take_.is_seen(f, k)) continue;
        sum[k] += (take_.position_mm.block<1, 3>(f, 3 * k) - take_.position_mm.block<1, 3>(f, 3 * i)).norm();
        count[k] += 1;
      }
    }
    return sum.cwiseQuotient(count.cwiseMax(1));
  }

  /// Whole markers, and near ones with gaps that are seen throughout the gaps of i.
  Indices helpers(Eigen::Index i, const Eigen::VectorXd& distance_mm) const {
    Indices used = whole_;
    for (const Eigen::Index k : gapped_) {
      if (k == i || distance_mm[k] > options_.distal_threshold * distance_mm.mean()) continue;
      bool overlaps = false;
      for (Eigen::Index f = 0; f < take_.frames(); ++f) {
        overlaps = overlaps || (!take_.is_seen(f, i) && !take_.is_seen(f, k));
      }
      if (!overlaps) used.push_back(k);
    }
    return used;
  }

  const MarkerMatrix& take_;
  const PcaFillOptions& options_;
  Eigen::MatrixXd relative_mm_, centre_mm_;
  Indices whole_, gapped_;
};

}  // namespace

void fill_pca(std::vector<MarkerFrame>& frames, std::int64_t max_gap_ns, const PcaFillOptions& options) {
  const MarkerMatrix take(frames);
  PcaFiller filler(take, options);
  Eigen::MatrixXd filled_mm = take.position_mm;
  bool all = filler.can_centre();
  if (all) filler.centre();
  std::vector<std::uint8_t> is_done(static_cast<std::size_t>(take.markers()), 1);
  for (const Eigen::Index i : filler.gapped()) {
    is_done[static_cast<std::size_t>(i)] = filler.can_centre() && filler.fill(i, filled_mm);
    all = all && is_done[static_cast<std::size_t>(i)];
  }
  if (!all) {
    std::vector<MarkerFrame> straight = frames;
    fill_linear(straight, max_gap_ns);
    const MarkerMatrix& seen = take;
    for (Eigen::Index i = 0; i < seen.markers(); ++i) {
      if (is_done[static_cast<std::size_t>(i)]) continue;
      for (Eigen::Index f = 0; f < seen.frames(); ++f) {
        const Position p = straight[static_cast<std::size_t>(f)].position_mm[static_cast<std::size_t>(i)];
        filled_mm.block<1, 3>(f, 3 * i) << p.x, p.y, p.z;
      }
    }
  }
  write_filled(frames, take, filled_mm, max_gap_ns);
}

}  // namespace risorius
