// What lies behind the built-in face's openings: eyeballs, teeth, the pocket of the mouth. They are not skin: no marker
// sits on them. Each part is added with its left triangles only; the mesh mirrors them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "solve/faces/builtin_head_mesh.h"

namespace risorius {

/// The mesh while it is being built.
struct HeadPartBuilder {
  std::vector<Eigen::Vector3d>* points = nullptr;
  HeadMesh* mesh = nullptr;
  std::vector<Eigen::Vector3i> left;

  int add(const Eigen::Vector3d& p, HeadPart part, int anchor, bool is_above_mouth);
  /// One of the two, where both sides are made together.
  void pair(int left_vertex, int right_vertex);
};

/// The lip edges of `mesh` must be there.
void add_inner_parts(HeadPartBuilder& builder);

}  // namespace risorius
