#include "replay/picture/mesh_view.h"

#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace risorius;

/// A square in the plane z, 2 x half_mm wide, facing the camera.
struct Square {
  Eigen::Matrix3Xd vertices_mm{3, 4};
  Eigen::Matrix3Xi triangles{3, 2};
  Eigen::Matrix3Xd colours{3, 4};
  Square(double half_mm, double z_mm, const Eigen::Vector3d& colour) {
    vertices_mm << -half_mm, half_mm, half_mm, -half_mm, -half_mm, -half_mm, half_mm, half_mm, z_mm, z_mm, z_mm, z_mm;
    triangles << 0, 0, 1, 2, 2, 3;
    colours.colwise() = colour;
  }
  ShadedMesh mesh() const { return {vertices_mm, triangles, colours}; }
};

const MeshCamera kCamera{.target_mm = {0, 0, 0}, .turned_degrees = 0, .distance_mm = 1000, .field_mm = 100};
constexpr std::uint32_t kPaper = 0xffffffff;

int red(std::uint32_t pixel) { return static_cast<int>(pixel >> 16 & 0xff); }
int blue(std::uint32_t pixel) { return static_cast<int>(pixel & 0xff); }

Canvas painted(const MeshView& view) {
  Canvas canvas(100, 100);
  view.paint_on(canvas, {0, 0});
  return canvas;
}

TEST(MeshView, DrawsWhereTheMeshIsAndLeavesTheRest) {
  const Square square(20, 0, {1, 0, 0});
  MeshView view(100, 100, kCamera);
  view.draw(square.mesh());
  const Canvas canvas = painted(view);
  EXPECT_GT(red(canvas.pixel(50, 50)), 100);
  EXPECT_LT(blue(canvas.pixel(50, 50)), 90);
  EXPECT_NE(canvas.pixel(32, 50), kPaper);  // 1 pixel per mm: the square ends at pixels 30 and 70
  EXPECT_EQ(canvas.pixel(28, 50), kPaper);
  EXPECT_EQ(canvas.pixel(50, 73), kPaper);
}

TEST(MeshView, NearerSurfacesHideFurtherOnesInAnyOrder) {
  const Square near(10, 5, {0, 0, 1}), far(20, -5, {1, 0, 0});
  for (const bool near_first : {true, false}) {
    MeshView view(100, 100, kCamera);
    view.draw(near_first ? near.mesh() : far.mesh());
    view.draw(near_first ? far.mesh() : near.mesh());
    const Canvas canvas = painted(view);
    EXPECT_GT(blue(canvas.pixel(50, 50)), red(canvas.pixel(50, 50)));
    EXPECT_GT(red(canvas.pixel(35, 50)), blue(canvas.pixel(35, 50)));
    EXPECT_TRUE(view.is_visible({0, 0, 5}));
    EXPECT_FALSE(view.is_visible({0, 0, -5}));
    EXPECT_TRUE(view.is_visible({15, 0, -5}));
    EXPECT_FALSE(view.is_visible({500, 0, 0}));
  }
}

TEST(MeshView, DoesNotDrawBacks) {
  Square square(20, 0, {1, 0, 0});
  square.triangles.row(1).swap(square.triangles.row(2));
  MeshView view(100, 100, kCamera);
  view.draw(square.mesh());
  EXPECT_EQ(painted(view).pixel(50, 50), kPaper);
}

TEST(MeshView, ProjectsAsItDraws) {
  const MeshView front(100, 100, kCamera);
  EXPECT_NEAR(front.project({0, 0, 0}).x, 50, 1e-9);
  EXPECT_NEAR(front.project({20, 0, 0}).x, 70, 1e-9);  // the subject's left is the picture's right
  EXPECT_NEAR(front.project({0, 20, 0}).y, 30, 1e-9);
  EXPECT_GT(front.project({20, 0, 100}).x, 70);  // perspective
  MeshCamera turned = kCamera;
  turned.turned_degrees = 90;
  const MeshView side(100, 100, turned);
  // From the subject's left, the nose points to the picture's left.
  EXPECT_NEAR(side.project({0, 0, 20}).x, 30, 1e-9);
}

TEST(MeshView, RefusesImpossibleCameras) {
  EXPECT_THROW(MeshView(0, 10, kCamera), std::invalid_argument);
  MeshCamera camera = kCamera;
  camera.field_mm = 0;
  EXPECT_THROW(MeshView(10, 10, camera), std::invalid_argument);
  camera = kCamera;
  camera.distance_mm = -1;
  EXPECT_THROW(MeshView(10, 10, camera), std::invalid_argument);
}

}  // namespace
