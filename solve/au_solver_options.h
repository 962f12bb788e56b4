// Options of AuSolver. Ridge, temporal and left-right penalties are relative to the mean diagonal of the rig's Gram
// matrix (mm^2), so that they mean the same for 16 markers and for 256.
#pragma once

#include "solve/head_pose.h"

namespace risorius {

struct AuSolverOptions {
  double noise_mm = 0.2;        ///< (0, 10]: standard deviation of a measured marker, per axis
  double ridge = 1e-3;          ///< [1e-9, 1]: pulls intensities to 0
  double temporal = 0.05;       ///< [0, 1000]: pulls a resting AU to the last frame, at 60 Hz; inverse to the time step
  double temporal_speed = 1.2;  ///< (0, 1000], intensity per s: an AU that moves so fast is pulled half as much
  double l1 = 20;  ///< [0, 1000]: linear cost of intensity times the residuals' variance: 20 if AUs are 0.05 on average
  double left_right = 0;             ///< [0, 1000]: pulls AUnL and AUnR together
  double robust_threshold_mm = 2.5;  ///< (0, 1000]: a marker further off than this loses weight
  int robust_iterations = 5;         ///< 0 to 20; 0 = plain least squares
  double min_visible_share = 0.25;  ///< (0, 1]: of an AU's displacement energy that must be visible to call it observed
  double largest_median_mm = 20;    ///< (0, 1000]: a frame whose median marker fits worse has no AUs
  int pose_steps = 4;  ///< 0 to 20: most joint steps of pose and AUs; 0 = the pose of the stabilisers or the last face
  HeadPoseOptions pose;
};

/// Throws std::invalid_argument naming the option, its value and its range.
void validate(const AuSolverOptions& options);

}  // namespace risorius
