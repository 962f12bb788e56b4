// A face model is a triangle mesh at rest, one displacement field per AU, and named places on the mesh: landmarks, and
// layouts of markers. It is the generic person that rig_fit carries over to an actor. Millimetres; x to the subject's
// left, y up, z out of the face. Immutable after construction.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "solve/faces/identity_warp.h"
#include "solve/faces/surface_tree.h"

namespace risorius {

/// A shape of the face, named like a rig's columns (solve/rig.h).
struct FaceAu {
  std::string name;
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x V, at intensity 1
  double upper_bound = 1.2;
  bool in_rigs = true;  ///< false: markers cannot tell it from a mixture of others; rigs leave it out
};

struct NamedPlace {
  std::string name;
  SurfacePoint place;
};

/// What a face is made of.
struct FaceParts {
  std::string name;
  Eigen::Matrix3Xd vertices_mm;  ///< 3 x V
  Eigen::Matrix3Xi triangles;    ///< 3 x F, counter-clockwise seen from outside
  int skin_triangle_count =
      0;                     ///< the first so many triangles are skin, where markers can sit; the rest eyes, teeth, ...
  Eigen::Matrix3Xd colours;  ///< for pictures: 3 x V, sRGB 0 to 1; or 3 x 0: skin all over
  std::vector<FaceAu> aus;
  std::map<std::string, SurfacePoint, std::less<>> landmarks;
  std::map<std::string, std::vector<NamedPlace>, std::less<>> layouts;
};

class FaceModel {
 public:
  /// Throws std::invalid_argument naming the part that does not fit: sizes, indices, values that are not finite,
  /// barycentric weights, AU names given twice.
  explicit FaceModel(FaceParts parts);

  const std::string& name() const noexcept { return parts_.name; }
  const Eigen::Matrix3Xd& vertices_mm() const noexcept { return parts_.vertices_mm; }
  const Eigen::Matrix3Xi& triangles() const noexcept { return parts_.triangles; }
  int skin_triangle_count() const noexcept { return parts_.skin_triangle_count; }
  const Eigen::Matrix3Xd& colours() const noexcept { return parts_.colours; }
  const std::vector<FaceAu>& aus() const noexcept { return parts_.aus; }
  /// Null where the face has none of this name.
  const FaceAu* find_au(std::string_view name) const noexcept;
  const SurfacePoint* find_landmark(std::string_view name) const noexcept;
  const std::vector<NamedPlace>* find_layout(std::string_view name) const noexcept;
  const std::map<std::string, SurfacePoint, std::less<>>& landmarks() const noexcept { return parts_.landmarks; }

  /// The closest point of the skin at rest.
  ClosestPoint closest_skin_point(const Eigen::Vector3d& point_mm) const noexcept { return skin_.closest_to(point_mm); }
  /// A field over the vertices (3 x V: positions or a displacement) at a place, interpolated over its triangle.
  Eigen::Vector3d at(const Eigen::Matrix3Xd& field, const SurfacePoint& place) const noexcept;
  Eigen::Vector3d position_mm(const SurfacePoint& place) const noexcept { return at(parts_.vertices_mm, place); }
  /// Another person at rest, without AUs: the vertices carried over by the warp.
  FaceModel warped_at_rest(const IdentityWarp& warp) const;
  /// Out of the skin at rest, of length 1.
  Eigen::Vector3d normal(const SurfacePoint& place) const noexcept;
  /// The vertices with AUs applied: 3 x V. `intensities` one per AU.
  Eigen::Matrix3Xd deformed_mm(const Eigen::VectorXd& intensities) const;

 private:
  FaceParts parts_;
  SurfaceTree skin_;
};

/// The place of a vertex: a corner of the first triangle that has it. Triangle -1 if none has.
SurfacePoint place_of_vertex(const Eigen::Matrix3Xi& triangles, int vertex) noexcept;

}  // namespace risorius
