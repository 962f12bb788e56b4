// Shaded pictures of a triangle mesh: a small z-buffer rasteriser with smooth normals, a key and a fill light, darker
// hollows, and two samples per pixel and axis. The camera stands in front of the face and is turned about the vertical
// axis. Mesh in mm; x to the subject's left, y up, z out of the face.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "replay/picture/canvas.h"
#include "replay/picture/facial_creases.h"

namespace risorius {

struct MeshCamera {
  Eigen::Vector3d target_mm{0, 10, 50};  ///< in the middle of the picture
  double turned_degrees = 0;             ///< to the subject's left; 0: from the front
  double distance_mm = 1100;             ///< from the target, > 0
  double field_mm = 250;                 ///< height of the picture at the target, > 0
};

/// What is drawn: vertices 3 x V, triangles 3 x F, colours sRGB 3 x V in 0 to 1 (3 x 0: skin all over).
struct ShadedMesh {
  const Eigen::Matrix3Xd& vertices_mm;
  const Eigen::Matrix3Xi& triangles;
  const Eigen::Matrix3Xd& colours;
  /// Optional: creases over the first so many triangles, placed by the vertices at rest (3 x V).
  const CreaseShade* creases = nullptr;
  const Eigen::Matrix3Xd* rest_mm = nullptr;
  int creased_triangles = 0;
};

class MeshView {
 public:
  /// A picture of `width` x `height` pixels, empty. Throws std::invalid_argument for sizes or a camera out of range.
  MeshView(int width, int height, const MeshCamera& camera);

  /// Adds a mesh; several hide one another as their depths say.
  void draw(const ShadedMesh& mesh);
  /// Copies the picture onto a canvas; where nothing was drawn the canvas stays.
  void paint_on(Canvas& canvas, PicturePoint at) const;

  /// Where a point appears, in pixels of this view.
  PicturePoint project(const Eigen::Vector3d& point_mm) const noexcept;
  /// False where the drawn meshes are nearer to the camera by more than `tolerance_mm`, or outside the picture.
  bool is_visible(const Eigen::Vector3d& point_mm, double tolerance_mm = 2) const noexcept;

 private:
  struct Corner {
    Eigen::Vector3d view_mm, normal, colour, rest_mm;
    double shade;
  };
  Eigen::Vector3d view_of(const Eigen::Vector3d& point_mm) const noexcept;
  Eigen::Vector2d sample_of(const Eigen::Vector3d& view_mm) const noexcept;
  void draw_triangle(const Corner& a, const Corner& b, const Corner& c, const CreaseShade* creases);
  Eigen::Vector3f light_of(const Corner& at, const CreaseShade* creases) const;

  int width_, height_;
  MeshCamera camera_;
  double samples_per_mm_;
  Eigen::Matrix3d view_from_head_;
  std::vector<float> nearness_;         ///< 1 / distance per sample, 0 where nothing is
  std::vector<Eigen::Vector3f> light_;  ///< linear RGB per sample
};

}  // namespace risorius
