// The closest point of a triangle surface, by a tree of bounding boxes (median split on the longest axis, exact
// point-triangle distance at the leaves). Built once; queries do not allocate and are const, so threads may share it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace risorius {

/// A place on a surface: a triangle of the mesh and the weights of its corners (>= 0, sum 1).
struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

struct ClosestPoint {
  SurfacePoint place;
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  double distance_mm = 0;
};

class SurfaceTree {
 public:
  /// Vertices 3 x V in mm, triangles 3 x F vertex indices in range; the tree holds the first `triangle_count`
  /// triangles. Throws std::invalid_argument for no triangle.
  SurfaceTree(const Eigen::Matrix3Xd& vertices_mm, const Eigen::Matrix3Xi& triangles, int triangle_count);

  /// Of several closest triangles any one, always the same. The point must be finite.
  ClosestPoint closest_to(const Eigen::Vector3d& point_mm) const noexcept;

 private:
  struct Corners {
    Eigen::Vector3d a, b, c;
    int triangle;
  };
  struct Node {
    Eigen::Vector3d low, high;
    std::int32_t first = 0;  ///< leaf: its first triangle; inner: its right child (the left one follows the node)
    std::int32_t count = 0;  ///< leaf: how many triangles; inner: 0
  };

  void build(std::int32_t first, std::int32_t last);
  void search(std::int32_t node, const Eigen::Vector3d& point_mm, ClosestPoint& best,
              double& best_squared) const noexcept;

  std::vector<Corners> corners_;
  std::vector<Node> nodes_;
};

/// The weights of the corners a, b, c at the point of the triangle that is closest to p (Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.5). A triangle without area gives a point on one of its edges.
Eigen::Vector3d closest_barycentric(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) noexcept;

}  // namespace risorius
