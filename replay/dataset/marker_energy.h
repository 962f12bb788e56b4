// How much of the markers' motion is explained: by the head's rigid motion alone, and with the AUs.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "replay/pipeline/frame_pipeline.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// Sums of squared distances over the measured markers of solved frames, in mm^2:
///   total  the marker against the rig's neutral in the head pose of the first solved frame
///   rigid  against the neutral in the frame's own head pose
///   aus    against the neutral plus the solved AUs in the frame's own head pose
class MarkerEnergy {
 public:
  MarkerEnergy(const Rig& rig, const std::vector<std::string>& marker_names);
  void add(const SolvedFrame& frame);

  /// 1 - rigid / total and 1 - aus / total; 0 before any motion.
  double explained_by_head() const noexcept;
  double explained_with_aus() const noexcept;
  /// 1 - aus / rigid: what the AUs explain of the motion that the head leaves.
  double face_explained_by_aus() const noexcept;
  /// Root mean square distance that remains per marker, mm.
  double residual_rms_mm() const noexcept;

 private:
  Eigen::Matrix3Xd neutral_mm_;
  std::vector<Eigen::Matrix3Xd> fields_mm_;
  std::vector<int> set_index_;
  std::optional<Pose> first_pose_;
  double total_ = 0, rigid_ = 0, aus_ = 0;
  double samples_ = 0;
};

}  // namespace risorius
