#include "solve/mirror_check.h"

#include <limits>

#include "capture/rigid_alignment.h"

namespace risorius {
namespace {

/// A mirror image fits better than the face by so much, in squares, only if the face is the mirror image.
constexpr double kMirrorGain = 4;

}  // namespace

MirrorCheck::MirrorCheck(const Rig& rig)
    : head_mm_(rig.marker_count()), world_mm_(rig.marker_count()), weight_(rig.marker_count()) {}

bool MirrorCheck::looks_mirrored(const Rig& rig, const RigMarkers& markers) noexcept {
  for (std::size_t m = 0; m < weight_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    head_mm_[m] = rig.neutral_mm.col(column);
    world_mm_[m] = markers.world_mm(m);
    weight_[m] = markers.weight()[column];
  }
  const double as_seen = mean_square_mm2();
  for (Eigen::Vector3d& p : world_mm_) p.x() = -p.x();
  return kMirrorGain * mean_square_mm2() < as_seen;
}

double MirrorCheck::mean_square_mm2() const noexcept {
  const RigidAlignment fit = align_rigid(head_mm_, world_mm_, weight_);
  double sum = 0;
  for (std::size_t m = 0; m < weight_.size(); ++m) {
    sum += weight_[m] * (fit.to_from * head_mm_[m] - world_mm_[m]).squaredNorm();
  }
  return fit.determined ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace risorius
