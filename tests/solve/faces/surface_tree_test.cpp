#include "solve/faces/surface_tree.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/allocation_counter.h"

namespace {

using risorius::ClosestPoint;
using risorius::SurfaceTree;

/// Numbers in [-1, 1), the same on every library.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : engine_(seed) {}
  Eigen::Vector3d point() { return {next(), next(), next()}; }

 private:
  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-52 - 1; }
  std::mt19937_64 engine_;
};

struct Soup {
  Eigen::Matrix3Xd vertices;
  Eigen::Matrix3Xi triangles;
};

Soup random_soup(int triangle_count, std::uint64_t seed) {
  Numbers numbers(seed);
  Soup soup{Eigen::Matrix3Xd(3, 3 * triangle_count), Eigen::Matrix3Xi(3, triangle_count)};
  for (int t = 0; t < triangle_count; ++t) {
    const Eigen::Vector3d centre = 100 * numbers.point();
    for (int corner = 0; corner < 3; ++corner) soup.vertices.col(3 * t + corner) = centre + 15 * numbers.point();
    soup.triangles.col(t) = Eigen::Vector3i(3 * t, 3 * t + 1, 3 * t + 2);
  }
  return soup;
}

TEST(SurfaceTree, FindsWhatASearchOfAllTrianglesFinds) {
  const Soup soup = random_soup(200, 1);
  const SurfaceTree tree(soup.vertices, soup.triangles, 200);
  Numbers numbers(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = 130 * numbers.point();
    double least = std::numeric_limits<double>::infinity();
    for (int t = 0; t < 200; ++t) {
      const Eigen::Vector3d w = risorius::closest_barycentric(p, soup.vertices.col(3 * t), soup.vertices.col(3 * t + 1),
                                                              soup.vertices.col(3 * t + 2));
      least = std::min(least, (soup.vertices.middleCols(3 * t, 3) * w - p).norm());
    }
    EXPECT_DOUBLE_EQ(tree.closest_to(p).distance_mm, least);
  }
}

TEST(SurfaceTree, NoOtherPointOfTheTriangleIsCloser) {
  Numbers numbers(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d a = numbers.point(), b = numbers.point(), c = numbers.point(), p = 2 * numbers.point();
    const Eigen::Vector3d w = risorius::closest_barycentric(p, a, b, c);
    EXPECT_GE(w.minCoeff(), -1e-12);
    EXPECT_NEAR(w.sum(), 1, 1e-12);
    const double distance = (w[0] * a + w[1] * b + w[2] * c - p).norm();
    for (int u = 0; u <= 20; ++u) {
      for (int v = 0; u + v <= 20; ++v) {
        const Eigen::Vector3d other = (a * (20 - u - v) + b * u + c * v) / 20;
        EXPECT_LE(distance, (other - p).norm() + 1e-12);
      }
    }
  }
}

TEST(SurfaceTree, APointOfTheSurfaceIsItsOwnClosestPoint) {
  const Soup soup = random_soup(50, 4);
  const SurfaceTree tree(soup.vertices, soup.triangles, 50);
  for (int t = 0; t < 50; ++t) {
    const Eigen::Vector3d p = soup.vertices.middleCols(3 * t, 3) * Eigen::Vector3d(0.2, 0.3, 0.5);
    EXPECT_LT(tree.closest_to(p).distance_mm, 1e-10);
  }
}

TEST(SurfaceTree, ATriangleWithoutAreaStillHasAClosestPoint) {
  const Eigen::Vector3d a(0, 0, 0), b(2, 0, 0), c(1, 0, 0), p(0.5, 3, 0);
  const Eigen::Vector3d w = risorius::closest_barycentric(p, a, b, c);
  EXPECT_NEAR((w[0] * a + w[1] * b + w[2] * c - p).norm(), 3, 1e-12);
  const Eigen::Vector3d point = risorius::closest_barycentric(p, a, a, a);
  EXPECT_NEAR(point.sum(), 1, 1e-12);
}

TEST(SurfaceTree, UsesOnlyTheFirstTriangles) {
  const Soup soup = random_soup(20, 5);
  const SurfaceTree tree(soup.vertices, soup.triangles, 5);
  for (int t = 0; t < 20; ++t) EXPECT_LT(tree.closest_to(soup.vertices.col(3 * t)).place.triangle, 5);
}

TEST(SurfaceTree, QueriesAllocateNothing) {
  const Soup soup = random_soup(100, 6);
  const SurfaceTree tree(soup.vertices, soup.triangles, 100);
  const auto before = risorius::test::allocations_of_this_thread();
  const ClosestPoint closest = tree.closest_to({1, 2, 3});
  EXPECT_EQ(risorius::test::allocations_of_this_thread(), before);
  EXPECT_GE(closest.place.triangle, 0);
}

TEST(SurfaceTree, RefusesToBeEmpty) {
  const Soup soup = random_soup(3, 7);
  EXPECT_THROW(SurfaceTree(soup.vertices, soup.triangles, 0), std::invalid_argument);
  EXPECT_THROW(SurfaceTree(soup.vertices, soup.triangles, 4), std::invalid_argument);
}

}  // namespace
