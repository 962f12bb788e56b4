// Fits a generic face to an actor: registers the actor's neutral markers to the face's skin and carries the face's AU
// shapes over to the markers. The rig stays in the actor's millimetres: the face and its shapes are scaled to the
// actor. Head frame: the axes and the origin of the face model (x to the subject's left, y up, z out of the face).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "capture/rigid_alignment.h"
#include "solve/faces/face_model.h"
#include "solve/faces/landmark_map.h"
#include "solve/rigs/rig.h"

namespace risorius {

struct RigFitOptions {
  int iterations = 60;                ///< of closest points, 1 to 1000
  double robust_mm = 8;               ///< distance at which a marker's pull stops growing (Huber), > 0
  double far_mm = 50;                 ///< a marker further off the skin is none of the face's, >= robust_mm
  double landmark_weight = 0.3;       ///< of a landmark pair beside a marker, in the refinement, >= 0
  bool with_identity = true;          ///< the face is bent to the actor, coarsely
  IdentityPrior identity;             ///< how far, and how smoothly, in the face's mm
  double landmark_deviation_mm = 10;  ///< of a marker from its landmark, in the face's mm, > 0
  double skin_deviation_mm = 2;       ///< of a marker from the skin, along the normal, in the face's mm, > 0
  double least_motion_mm = 0.3;       ///< an AU that moves every marker less is dropped, >= 0
  double largest_median_mm = 15;      ///< markers to skin, median
  double largest_landmark_mm = 25;    ///< mapped marker to its landmark
  double smallest_scale = 0.5, largest_scale = 2;  ///< actor / face
  double largest_tilt_degrees = 60;                ///< head's up to the world's up; 180 for actors who lie
};

struct RigFitResult {
  Rig rig;
  RigidTransform head_from_world;                                ///< of the neutral as it was handed in
  double scale = 1;                                              ///< actor's mm per face model's mm
  double median_distance_mm = 0;                                 ///< markers to skin; per marker in rig.fit_distance_mm
  double landmark_rms_mm = 0, largest_landmark_residual_mm = 0;  ///< of the generic face
  double generic_median_distance_mm = 0;                         ///< markers to the skin before the face was bent
  double identity_rms_mm = 0;            ///< by how much the face was bent where the markers are; 0 without identity
  std::vector<SurfacePoint> places;      ///< of the rig's markers on the face model's triangles
  std::vector<std::string> dropped_aus;  ///< no marker sees them
  std::vector<std::string> left_out_markers;  ///< never seen in the neutral, or far off the skin: a warning says which
  std::vector<std::string> warnings;          ///< one sentence each: unmapped landmarks, chosen stabilisers, AUs alike
};

/// Neutral positions 3 x M in the actor's mm, world LUF; a column that is not finite was never seen and is left out.
/// Markers far off the skin are left out, unless the map has them for stabilisers (headbands); they bend nothing.
/// Throws UserError: fewer than four landmarks, all of them in the middle, markers mirrored, or a fit that no head can
/// have (the values and limits are in the message). Throws std::invalid_argument for options out of range.
RigFitResult fit_rig(const FaceModel& face, const std::vector<std::string>& marker_names,
                     const Eigen::Matrix3Xd& neutral_mm, const LandmarkMap& map, const RigFitOptions& options = {});

}  // namespace risorius
