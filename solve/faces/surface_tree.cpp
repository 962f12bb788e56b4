#include "solve/faces/surface_tree.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr std::int32_t kTrianglesPerLeaf = 4;

double squared_distance_to_box(const Eigen::Vector3d& p, const Eigen::Vector3d& low,
                               const Eigen::Vector3d& high) noexcept {
  return (p - p.cwiseMax(low).cwiseMin(high)).squaredNorm();
}

/// `part / whole`, 0 for an edge without length.
double share(double part, double whole) noexcept { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; }

}  // namespace

Eigen::Vector3d closest_barycentric(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) noexcept {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = share(d1, d1 - d3);
    return {1 - v, v, 0};
  }
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = share(d2, d2 - d6);
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = share(d4 - d3, (d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {1 - vb / sum - vc / sum, vb / sum, vc / sum};
}

SurfaceTree::SurfaceTree(const Eigen::Matrix3Xd& vertices_mm, const Eigen::Matrix3Xi& triangles, int triangle_count) {
  if (triangle_count < 1 || triangle_count > triangles.cols()) {
    throw std::invalid_argument("SurfaceTree: triangle_count must be 1 to " + std::to_string(triangles.cols()));
  }
  corners_.reserve(static_cast<std::size_t>(triangle_count));
  for (int t = 0; t < triangle_count; ++t) {
    const Eigen::Vector3i v = triangles.col(t);
    corners_.push_back({vertices_mm.col(v[0]), vertices_mm.col(v[1]), vertices_mm.col(v[2]), t});
  }
  nodes_.reserve(2 * corners_.size());
  build(0, triangle_count);
}

void SurfaceTree::build(std::int32_t first, std::int32_t last) {
  Node node;
  node.low.setConstant(std::numeric_limits<double>::infinity());
  node.high = -node.low;
  for (std::int32_t i = first; i < last; ++i) {
    const Corners& t = corners_[static_cast<std::size_t>(i)];
    node.low = node.low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    node.high = node.high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
  }
  const std::size_t place = nodes_.size();
  node.first = first;
  node.count = last - first;
  nodes_.push_back(node);
  if (node.count <= kTrianglesPerLeaf) return;

  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const std::int32_t middle = first + node.count / 2;
  const auto centre_less = [axis](const Corners& l, const Corners& r) {
    const double a = l.a[axis] + l.b[axis] + l.c[axis], b = r.a[axis] + r.b[axis] + r.c[axis];
    return a != b ? a < b : l.triangle < r.triangle;
  };
  std::nth_element(corners_.begin() + first, corners_.begin() + middle, corners_.begin() + last, centre_less);
  build(first, middle);
  nodes_[place].first = static_cast<std::int32_t>(nodes_.size());
  nodes_[place].count = 0;
  build(middle, last);
}

void SurfaceTree::search(std::int32_t index, const Eigen::Vector3d& point_mm, ClosestPoint& best,
                         double& best_squared) const noexcept {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.count == 0) {
    const auto distance = [&](std::int32_t child) {
      const Node& n = nodes_[static_cast<std::size_t>(child)];
      return squared_distance_to_box(point_mm, n.low, n.high);
    };
    std::int32_t near = index + 1, far = node.first;
    double near_squared = distance(near), far_squared = distance(far);
    if (far_squared < near_squared) {
      std::swap(near, far);
      std::swap(near_squared, far_squared);
    }
    if (near_squared < best_squared) search(near, point_mm, best, best_squared);
    if (far_squared < best_squared) search(far, point_mm, best, best_squared);
    return;
  }
  for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
    const Corners& t = corners_[static_cast<std::size_t>(i)];
    const Eigen::Vector3d weights = closest_barycentric(point_mm, t.a, t.b, t.c);
    const Eigen::Vector3d position = weights[0] * t.a + weights[1] * t.b + weights[2] * t.c;
    const double squared = (point_mm - position).squaredNorm();
    if (squared >= best_squared) continue;
    best_squared = squared;
    best = {{t.triangle, weights}, position, std::sqrt(squared)};
  }
}

ClosestPoint SurfaceTree::closest_to(const Eigen::Vector3d& point_mm) const noexcept {
  ClosestPoint best;
  double best_squared = std::numeric_limits<double>::infinity();
  search(0, point_mm, best, best_squared);
  return best;
}

}  // namespace risorius
