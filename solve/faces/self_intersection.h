// Where a triangle mesh cuts through itself, and where it is turned inside out. For checks of faces, not for frames.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace risorius {

/// Pairs (a < b) of the first `triangle_count` triangles that intersect without sharing a vertex; at most `limit`. An
/// edge of one must pass through the inside of the other; mere touching does not count. Vertices in mm.
std::vector<std::pair<int, int>> self_intersections(const Eigen::Matrix3Xd& vertices_mm,
                                                    const Eigen::Matrix3Xi& triangles, int triangle_count,
                                                    std::size_t limit = 1000);

/// Triangles of the first `triangle_count` that face against the sum of their neighbours' normals, or whose area fell
/// below `least_share` of what it was at rest.
std::vector<int> flipped_triangles(const Eigen::Matrix3Xd& rest_mm, const Eigen::Matrix3Xd& deformed_mm,
                                   const Eigen::Matrix3Xi& triangles, int triangle_count, double least_share = 0.01);

}  // namespace risorius
