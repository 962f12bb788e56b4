#include "solve/faces/self_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

namespace risorius {
namespace {

struct Triangle {
  Eigen::Vector3d corner[3];
  Eigen::Vector3d low, high;
};

/// Does the edge from p to q pass through the inside of the triangle? (Signed volumes; touching is not passing.)
bool passes_through(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Triangle& t) noexcept {
  const auto volume = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                         const Eigen::Vector3d& d) { return (b - a).cross(c - a).dot(d - a); };
  const double at_p = volume(t.corner[0], t.corner[1], t.corner[2], p);
  const double at_q = volume(t.corner[0], t.corner[1], t.corner[2], q);
  constexpr double kTouch = 1e-9;  // mm^3
  if (!((at_p > kTouch && at_q < -kTouch) || (at_p < -kTouch && at_q > kTouch))) return false;
  const double v0 = volume(p, q, t.corner[0], t.corner[1]), v1 = volume(p, q, t.corner[1], t.corner[2]),
               v2 = volume(p, q, t.corner[2], t.corner[0]);
  return (v0 > kTouch && v1 > kTouch && v2 > kTouch) || (v0 < -kTouch && v1 < -kTouch && v2 < -kTouch);
}

bool intersect(const Triangle& a, const Triangle& b) noexcept {
  for (int k = 0; k < 3; ++k) {
    if (passes_through(a.corner[k], a.corner[(k + 1) % 3], b)) return true;
    if (passes_through(b.corner[k], b.corner[(k + 1) % 3], a)) return true;
  }
  return false;
}

bool share_a_vertex(const Eigen::Vector3i& a, const Eigen::Vector3i& b) noexcept {
  for (const int i : a) {
    if ((b.array() == i).any()) return true;
  }
  return false;
}

}  // namespace

std::vector<std::pair<int, int>> self_intersections(const Eigen::Matrix3Xd& vertices_mm,
                                                    const Eigen::Matrix3Xi& triangles, int triangle_count,
                                                    std::size_t limit) {
  std::vector<Triangle> all(static_cast<std::size_t>(triangle_count));
  for (int t = 0; t < triangle_count; ++t) {
    Triangle& triangle = all[static_cast<std::size_t>(t)];
    for (int k = 0; k < 3; ++k) triangle.corner[k] = vertices_mm.col(triangles(k, t));
    triangle.low = triangle.corner[0].cwiseMin(triangle.corner[1]).cwiseMin(triangle.corner[2]);
    triangle.high = triangle.corner[0].cwiseMax(triangle.corner[1]).cwiseMax(triangle.corner[2]);
  }
  // A sweep over y with the open triangles in bins of x: faces are wide and flat, so few boxes meet.
  std::vector<int> order(all.size());
  for (std::size_t t = 0; t < order.size(); ++t) order[t] = static_cast<int>(t);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return all[static_cast<std::size_t>(a)].low.y() < all[static_cast<std::size_t>(b)].low.y();
  });
  constexpr double kBinMm = 5;
  std::unordered_map<int, std::vector<int>> bins;
  std::vector<std::pair<int, int>> found;
  for (const int index : order) {
    const Triangle& triangle = all[static_cast<std::size_t>(index)];
    const int first = static_cast<int>(std::floor(triangle.low.x() / kBinMm));
    const int last = static_cast<int>(std::floor(triangle.high.x() / kBinMm));
    for (int bin = first; bin <= last; ++bin) {
      std::vector<int>& open = bins[bin];
      std::erase_if(open, [&](int other) { return all[static_cast<std::size_t>(other)].high.y() < triangle.low.y(); });
      for (const int other : open) {
        const Triangle& o = all[static_cast<std::size_t>(other)];
        const bool boxes_meet =
            (o.low.array() <= triangle.high.array()).all() && (triangle.low.array() <= o.high.array()).all();
        if (!boxes_meet || share_a_vertex(triangles.col(index), triangles.col(other)) || !intersect(triangle, o))
          continue;
        const std::pair<int, int> pair = std::minmax(index, other);
        if (std::find(found.begin(), found.end(), pair) != found.end()) continue;
        found.push_back(pair);
        if (found.size() >= limit) return found;
      }
      open.push_back(index);
    }
  }
  return found;
}

std::vector<int> flipped_triangles(const Eigen::Matrix3Xd& rest_mm, const Eigen::Matrix3Xd& deformed_mm,
                                   const Eigen::Matrix3Xi& triangles, int triangle_count, double least_share) {
  const auto normal = [&](const Eigen::Matrix3Xd& at, int t) {
    const Eigen::Vector3i v = triangles.col(t);
    const Eigen::Vector3d a = at.col(v[0]);
    return Eigen::Vector3d((at.col(v[1]) - a).cross(Eigen::Vector3d(at.col(v[2]) - a)));
  };
  std::map<std::pair<int, int>, int> triangle_of_edge;
  for (int t = 0; t < triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) triangle_of_edge[{triangles(k, t), triangles((k + 1) % 3, t)}] = t;
  }
  std::vector<int> flipped;
  for (int t = 0; t < triangle_count; ++t) {
    const Eigen::Vector3d now = normal(deformed_mm, t);
    Eigen::Vector3d around = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const auto neighbour = triangle_of_edge.find({triangles((k + 1) % 3, t), triangles(k, t)});
      if (neighbour != triangle_of_edge.end()) around += normal(deformed_mm, neighbour->second).normalized();
    }
    if (now.dot(around) < 0 || now.norm() < least_share * normal(rest_mm, t).norm()) flipped.push_back(t);
  }
  return flipped;
}

}  // namespace risorius
