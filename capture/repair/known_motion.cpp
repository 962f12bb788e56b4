#include "capture/repair/known_motion.h"

#include <algorithm>

#include "capture/marker_set.h"
#include "capture/rigid_alignment.h"

namespace risorius {
namespace {

/// Of the markers that are known, this share must have been seen before the axes are looked for.
constexpr double kSeenShare = 0.5;
constexpr std::ptrdiff_t kFewestSeen = 4;
/// With the median marker farther off, it is not this face, or mirrored.
constexpr double kFarthestMm = 12;
/// Markers so far off count a quarter: a false track must not decide.
constexpr double kRobustMm = 10;
constexpr int kReweightings = 5;

}  // namespace

void KnownModes::use(std::shared_ptr<const KnownMotion> known, const std::vector<std::string>& names) {
  known_ = std::move(known);
  index_.assign(names.size(), -1);
  if (known_) index_ = index_map(known_->marker_names, names);
  is_known_.assign(names.size(), 0);
  for (std::size_t i = 0; i < names.size(); ++i) is_known_[i] = index_[i] >= 0;
  rest_mm_.assign(names.size(), Eigen::Vector3d::Zero());
  seen_mm_ = rest_mm_;
  weight_.assign(names.size(), 0);
  trust_ = weight_;
  distance_mm_.reserve(names.size());
  modes_mm_.setZero(known_ ? static_cast<Eigen::Index>(known_->modes_mm.size()) : 0,
                    static_cast<Eigen::Index>(3 * names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (is_known_[i]) rest_mm_[i] = known_->rest_mm.col(index_[i]);
  }
  reset();
}

void KnownModes::reset() noexcept {
  is_aligned_ = is_refused_ = false;
  std::ranges::fill(weight_, 0.0);
}

void KnownModes::see(std::size_t i, const Eigen::Vector3d& position_mm) noexcept {
  if (!known_ || is_aligned_) return;
  seen_mm_[i] = position_mm;
  weight_[i] = is_known_[i];
}

void KnownModes::align() noexcept {
  if (!known_ || is_aligned_ || is_refused_) return;
  const std::ptrdiff_t seen = std::ranges::count(weight_, 1.0), known = std::ranges::count(is_known_, 1);
  if (seen < kFewestSeen || static_cast<double>(seen) < kSeenShare * static_cast<double>(known)) return;
  trust_ = weight_;
  RigidAlignment alignment = align_rigid(rest_mm_, seen_mm_, trust_);
  for (int k = 0; k < kReweightings && alignment.determined; ++k) {
    distance_mm_.clear();
    for (std::size_t i = 0; i < weight_.size(); ++i) {
      if (!(weight_[i] > 0)) continue;
      distance_mm_.push_back((alignment.to_from * rest_mm_[i] - seen_mm_[i]).norm());
      const double relative = distance_mm_.back() / kRobustMm;
      trust_[i] = 1 / ((1 + relative * relative) * (1 + relative * relative));
    }
    alignment = align_rigid(rest_mm_, seen_mm_, trust_);
  }
  const auto median = distance_mm_.begin() + static_cast<std::ptrdiff_t>(distance_mm_.size() / 2);
  if (alignment.determined) std::nth_element(distance_mm_.begin(), median, distance_mm_.end());
  is_refused_ = !alignment.determined || *median > kFarthestMm;
  if (is_refused_) return;
  is_aligned_ = true;
  const Eigen::Matrix3d rotation = alignment.to_from.rotation.toRotationMatrix();
  for (std::size_t i = 0; i < index_.size(); ++i) {
    if (!is_known_[i]) continue;
    for (Eigen::Index k = 0; k < modes_mm_.rows(); ++k) {
      modes_mm_.row(k).segment<3>(static_cast<Eigen::Index>(3 * i)) =
          (rotation * known_->modes_mm[static_cast<std::size_t>(k)].col(index_[i])).transpose();
    }
  }
}

}  // namespace risorius
