// The rigid pose of the head from the rig's stabilisers: weighted Horn alignment (capture/rigid_alignment.h), made
// robust so that one false stabiliser cannot bend it. Where all stabilisers agree, that is one alignment. Where not,
// the triple of stabilisers that most others agree with (least truncated squares) is the start of iteratively
// reweighted alignments. Stateless; allocates only when constructed.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "capture/rigid_alignment.h"

namespace risorius {

struct HeadPoseOptions {
  double robust_threshold_mm = 2;  ///< (0, 100]: a stabiliser further off than this loses weight
  int iterations = 8;              ///< 1 to 50
};

struct HeadPoseResult {
  RigidTransform world_from_head;
  double residual_rms_mm = 0;  ///< of the stabilisers that were trusted, weighted
  bool determined = false;     ///< at least 3 trusted stabilisers that are not collinear
};

class HeadPose {
 public:
  /// `capacity`: the most stabilisers there will be. Throws std::invalid_argument for options out of range.
  HeadPose(std::size_t capacity, const HeadPoseOptions& options);

  /// Stabilisers in the head frame (where the face is taken to be), as seen in the world, and their weights: 0 = not to
  /// be used (its position is not read), positions otherwise finite. Equal sizes, at most the capacity.
  HeadPoseResult estimate(std::span<const Eigen::Vector3d> head_mm, std::span<const Eigen::Vector3d> world_mm,
                          std::span<const double> weights) noexcept;

 private:
  struct Points {
    std::span<const Eigen::Vector3d> head_mm, world_mm;
    std::span<const double> weights;
  };
  void measure_distances(const Points& points, const RigidTransform& world_from_head) noexcept;
  RigidAlignment best_triple(const Points& points, const RigidAlignment& all) noexcept;
  RigidAlignment align_triple(const Points& points, int a, int b, int c) noexcept;
  double truncated_squares(const Points& points, const RigidTransform& world_from_head) noexcept;
  RigidAlignment reweigh(const Points& points, RigidAlignment alignment) noexcept;
  double threshold(std::span<const double> weights) noexcept;

  HeadPoseOptions options_;
  std::vector<double> trusted_weight_;
  std::vector<double> distance_mm_;
  std::vector<double> scratch_;
  std::vector<int> usable_;
};

}  // namespace risorius
