// What a face is measured by, for its tests and its bench: where each AU should move the skin, and figures of a face.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "solve/faces/face_model.h"

namespace risorius::test {

/// A box of the resting face seen from the front, mm.
struct FaceRegion {
  double least_x, greatest_x, least_y, greatest_y;
};

struct FaceCheck {
  std::string_view column;     ///< the left side stands for both
  FaceRegion region;           ///< where the AU's muscles and the skin that they carry lie
  std::vector<int> landmarks;  ///< of the 68, at which amplitudes are compared; none: the skin that moves most
};

std::span<const FaceCheck> face_checks();

/// Skin vertices that move at least half as much as the one that moves most.
struct Movers {
  Eigen::Vector3d mean_place_mm = Eigen::Vector3d::Zero(), mean_displacement_mm = Eigen::Vector3d::Zero();
};
Movers movers_of(const FaceModel& face, const FaceAu& au);

/// Share of the skin's squared displacement inside a region, each vertex weighted by its area.
double share_inside(const FaceModel& face, const FaceAu& au, const FaceRegion& region);

/// Cosine of the movers' mean with the direction of the AU's strongest straight muscle; empty if it has none.
std::optional<double> cosine_with_muscle(const FaceModel& builtin, const FaceAu& au);

/// Of the vertices and of all AU fields: left against the mirror image of right, mm. For the built-in face.
double largest_asymmetry_mm(const FaceModel& builtin);

/// The greatest distance of an upper lid's edge from the lower lid's edge at AU45 = 1, mm; negative where they cross.
double largest_lid_gap_mm(const FaceModel& builtin);

/// Self-intersections and turned triangles of the skin, summed over the neutral and all AUs one by one.
struct Integrity {
  int intersections_at_one = 0, intersections_at_bound = 0, flipped = 0;
};
/// Without `with_one` at the neutral and the upper bounds only, which takes half the time.
Integrity integrity_of(const FaceModel& face, bool with_one = true);

}  // namespace risorius::test
