#include "replay/picture/marker_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>
#include <vector>

namespace risorius {
namespace {

double twice_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) noexcept {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Is p inside the circle through the counter-clockwise a, b, c? (Guibas & Stolfi 1985.)
bool in_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
               const Eigen::Vector2d& p) noexcept {
  Eigen::Matrix3d m;
  m << a - p, b - p, c - p, Eigen::RowVector3d((a - p).squaredNorm(), (b - p).squaredNorm(), (c - p).squaredNorm());
  return m.determinant() > 1e-12;
}

}  // namespace

Eigen::Matrix3Xi triangulated_markers(const Eigen::Matrix3Xd& markers_mm, double longest_edge_mm) {
  const auto count = static_cast<int>(markers_mm.cols());
  if (count < 3) return Eigen::Matrix3Xi(3, 0);
  // Points enter one by one into a triangle around all of them (Bowyer 1981, Watson 1981).
  std::vector<Eigen::Vector2d> points;
  for (int m = 0; m < count; ++m) points.emplace_back(markers_mm.col(m).head<2>());
  const Eigen::Vector2d middle = markers_mm.topRows<2>().rowwise().mean();
  constexpr double kFarMm = 1e5;
  points.emplace_back(middle + Eigen::Vector2d(-kFarMm, -kFarMm));
  points.emplace_back(middle + Eigen::Vector2d(kFarMm, -kFarMm));
  points.emplace_back(middle + Eigen::Vector2d(0, kFarMm));
  const auto at = [&](int i) -> const Eigen::Vector2d& { return points[static_cast<std::size_t>(i)]; };
  std::vector<Eigen::Vector3i> triangles{{count, count + 1, count + 2}};
  for (int m = 0; m < count; ++m) {
    std::vector<std::pair<int, int>> rim;
    std::erase_if(triangles, [&](const Eigen::Vector3i& t) {
      if (!in_circle(at(t[0]), at(t[1]), at(t[2]), at(m))) return false;
      for (int k = 0; k < 3; ++k) {
        const std::pair edge(t[k], t[(k + 1) % 3]);
        const auto twin = std::find(rim.begin(), rim.end(), std::pair(edge.second, edge.first));
        twin == rim.end() ? rim.push_back(edge) : void(rim.erase(twin));
      }
      return true;
    });
    for (const auto& [from, to] : rim) {
      if (twice_area(at(from), at(to), at(m)) > 1e-9) triangles.emplace_back(from, to, m);
    }
  }
  std::erase_if(triangles, [&](const Eigen::Vector3i& t) {
    if (t.maxCoeff() >= count) return true;
    for (int k = 0; k < 3; ++k) {
      if ((markers_mm.col(t[k]) - markers_mm.col(t[(k + 1) % 3])).norm() > longest_edge_mm) return true;
    }
    return false;
  });
  Eigen::Matrix3Xi result(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) result.col(static_cast<Eigen::Index>(t)) = triangles[t];
  return result;
}

}  // namespace risorius
