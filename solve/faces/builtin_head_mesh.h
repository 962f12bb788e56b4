// The mesh of the built-in head: a grid of rings around the head with three slits (lids and lips), whose edges are
// doubled so that they part; behind them lid rims, the pocket of the mouth, teeth and eyeballs. Skin triangles come
// first. The right half is the mirror image of the left one, vertex by vertex and triangle by triangle.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace risorius {

/// What a vertex belongs to; it decides how AUs move it and what colour it has.
enum class HeadPart : std::uint8_t { kSkin, kLidRim, kMouthPocket, kUpperTeeth, kLowerTeeth, kEyeball, kTongue };

struct HeadMesh {
  Eigen::Matrix3Xd vertices_mm;
  Eigen::Matrix3Xi triangles;  ///< counter-clockwise seen from outside
  int skin_triangle_count = 0;
  std::vector<HeadPart> part;                       ///< per vertex
  std::vector<int> mirror_vertex;                   ///< its image in the plane x = 0; itself on the plane
  std::vector<int> mirror_triangle;                 ///< corners (a b c) are the images of (a c b)
  std::vector<int> anchor;                          ///< the skin vertex that it moves with; itself for skin
  std::vector<bool> is_above_mouth;                 ///< of the lips' line and its continuation around the head
  std::vector<bool> is_above_eye;                   ///< of the lids' slit
  std::vector<int> upper_lid_edge, lower_lid_edge;  ///< left eye, from the inner corner to the outer, corners included
  std::vector<int> upper_lip_edge, lower_lip_edge;  ///< from the right corner to the left, corners included
};

HeadMesh build_head_mesh();

}  // namespace risorius
