#include "solve/faces/face_model.h"

#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

namespace {

using namespace risorius;

/// A square of two triangles and one AU that lifts vertex 2.
FaceParts square() {
  FaceParts parts;
  parts.name = "square";
  parts.vertices_mm.resize(3, 4);
  parts.vertices_mm << 0, 10, 10, 0, 0, 0, 10, 10, 0, 0, 0, 0;
  parts.triangles.resize(3, 2);
  parts.triangles << 0, 0, 1, 2, 2, 3;
  parts.skin_triangle_count = 2;
  FaceAu au{"AU1", Eigen::Matrix3Xd::Zero(3, 4)};
  au.displacement_mm(2, 2) = 4;
  parts.aus.push_back(au);
  parts.landmarks["corner"] = place_of_vertex(parts.triangles, 2);
  return parts;
}

TEST(FaceModel, InterpolatesShapesOverATriangle) {
  const FaceModel face(square());
  const ClosestPoint closest = face.closest_skin_point({7.5, 5, 3});
  EXPECT_LT((closest.position_mm - Eigen::Vector3d(7.5, 5, 0)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(closest.distance_mm, 3);
  // (7.5, 5) = 0.25 of (0, 0), 0.25 of (10, 0) and 0.5 of (10, 10), which alone moves by 4.
  EXPECT_NEAR(face.at(face.find_au("AU1")->displacement_mm, closest.place).z(), 2, 1e-12);
}

TEST(FaceModel, AppliesAus) {
  const FaceModel face(square());
  EXPECT_DOUBLE_EQ(face.deformed_mm(Eigen::VectorXd::Constant(1, 0.5))(2, 2), 2);
  EXPECT_EQ(face.deformed_mm(Eigen::VectorXd::Zero(1)), face.vertices_mm());
  EXPECT_THROW(face.deformed_mm(Eigen::VectorXd::Zero(2)), std::invalid_argument);
}

TEST(FaceModel, FindsByName) {
  const FaceModel face(square());
  EXPECT_EQ(face.find_au("AU2"), nullptr);
  EXPECT_EQ(face.find_landmark("nose"), nullptr);
  EXPECT_EQ(face.find_layout("none"), nullptr);
  EXPECT_EQ(face.position_mm(*face.find_landmark("corner")), Eigen::Vector3d(10, 10, 0));
  EXPECT_EQ(place_of_vertex(face.triangles(), 9).triangle, -1);
}

TEST(FaceModel, RefusesPartsThatDoNotFit) {
  const auto refuses = [](auto change) {
    FaceParts parts = square();
    change(parts);
    EXPECT_THROW(FaceModel{parts}, std::invalid_argument);
  };
  refuses([](FaceParts& p) { p.triangles(0, 0) = 4; });
  refuses([](FaceParts& p) { p.triangles(0, 0) = -1; });
  refuses([](FaceParts& p) { p.triangles.resize(3, 0); });
  refuses([](FaceParts& p) { p.vertices_mm(0, 0) = std::numeric_limits<double>::quiet_NaN(); });
  refuses([](FaceParts& p) { p.skin_triangle_count = 3; });
  refuses([](FaceParts& p) { p.aus.push_back(p.aus[0]); });
  refuses([](FaceParts& p) { p.aus[0].displacement_mm.resize(3, 3); });
  refuses([](FaceParts& p) { p.aus[0].displacement_mm(1, 1) = std::numeric_limits<double>::infinity(); });
  refuses([](FaceParts& p) { p.landmarks["corner"].triangle = 2; });
  refuses([](FaceParts& p) { p.landmarks["corner"].barycentric = {0.5, 0.6, 0.1}; });
  refuses([](FaceParts& p) { p.layouts["one"].push_back({"M", {}}); });
}

}  // namespace
