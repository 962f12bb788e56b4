// A surface through a cloud of face markers, for pictures of rigs that have no mesh.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// Delaunay triangulation of the markers as seen from the front (x, y), counter-clockwise; triangles with an edge
/// longer than `longest_edge_mm` are left out. 3 x F indices; empty for fewer than three markers. Markers in mm, 3 x M.
Eigen::Matrix3Xi triangulated_markers(const Eigen::Matrix3Xd& markers_mm, double longest_edge_mm = 70);

}  // namespace risorius
