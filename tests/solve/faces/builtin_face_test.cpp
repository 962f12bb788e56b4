#include "solve/faces/builtin_face.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "solve/faces/builtin_face_shapes.h"

namespace {

using namespace risorius;

const FaceModel& face() {
  static const FaceModel model = builtin_face();
  return model;
}

const Rig& rig() {
  static const Rig built = builtin_rig_of(face());
  return built;
}

/// "AU12L" -> "AU12R" and back; shapes without a side are their own mirror image.
std::string other_side(std::string name) {
  if (name.back() == 'L') {
    name.back() = 'R';
  } else if (name.back() == 'R') {
    name.back() = 'L';
  }
  return name;
}

Eigen::Vector3d mirrored(const Eigen::Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

/// One column per AU, unit length.
Eigen::MatrixXd unit_basis() {
  Eigen::MatrixXd basis(3 * static_cast<Eigen::Index>(rig().marker_count()),
                        static_cast<Eigen::Index>(rig().au_count()));
  for (std::size_t k = 0; k < rig().au_count(); ++k) {
    basis.col(static_cast<Eigen::Index>(k)) = rig().aus[k].displacement_mm.reshaped().normalized();
  }
  return basis;
}

TEST(BuiltinFace, HasAHeadsSizeAndAFacesOrder) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  EXPECT_GT(v.cols(), 1500);
  EXPECT_LT(v.cols(), 4000);
  // Adult bizygomatic breadth is 125 to 145 mm (Farkas 1994); nose tip foremost.
  EXPECT_NEAR(v.row(0).maxCoeff() - v.row(0).minCoeff(), 140, 10);
  Eigen::Index foremost = 0;
  v.row(2).maxCoeff(&foremost);
  EXPECT_LT((v.col(foremost) - face().position_mm(*face().find_landmark("nose_tip"))).norm(), 5);
}

TEST(BuiltinFace, TrianglesFaceOutward) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  for (Eigen::Index t = 0; t < face().triangles().cols(); ++t) {
    const Eigen::Vector3i c = face().triangles().col(t);
    const Eigen::Vector3d normal = (v.col(c[1]) - v.col(c[0])).cross(v.col(c[2]) - v.col(c[0]));
    EXPECT_GT(normal.norm(), 0.1) << t;
    EXPECT_GT(normal.dot(Eigen::Vector3d(v(0, c[0]), 0, v(2, c[0]) + 40)), 0) << t;
  }
}

TEST(BuiltinFace, MeshAndShapesAreMirrorImages) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  for (Eigen::Index i = 0; i < v.cols(); ++i) {
    const ClosestPoint image = face().closest_skin_point(mirrored(v.col(i)));
    ASSERT_LT(image.distance_mm, 1e-9);
    if (i % 7 != 0) continue;
    for (const FaceAu& au : face().aus()) {
      const FaceAu* other = face().find_au(other_side(au.name));
      ASSERT_NE(other, nullptr) << au.name;
      const Eigen::Vector3d there = face().at(other->displacement_mm, image.place);
      EXPECT_LT((there - mirrored(au.displacement_mm.col(i))).norm(), 1e-9) << au.name << " at vertex " << i;
    }
  }
}

TEST(BuiltinFace, MarkersAreMirrorImagesOfEachOther) {
  const std::vector<std::string>& names = rig().marker_names;
  int pairs = 0;
  for (std::size_t a = 0; a < names.size(); ++a) {
    double nearest_mm = 1e9;
    for (std::size_t b = 0; b < names.size(); ++b) {
      const Eigen::Vector3d image = mirrored(rig().neutral_mm.col(static_cast<Eigen::Index>(a)));
      nearest_mm = std::min(nearest_mm, (rig().neutral_mm.col(static_cast<Eigen::Index>(b)) - image).norm());
    }
    EXPECT_LT(nearest_mm, 1e-9) << names[a];
    if (names[a].starts_with("LBRO")) {
      EXPECT_GT(rig().neutral_mm(0, static_cast<Eigen::Index>(a)), 0) << names[a];
      ++pairs;
    }
  }
  EXPECT_EQ(pairs, 4);
}

TEST(BuiltinFace, HasTheIemocapMarkersOnce) {
  std::set<std::string> expected{"CH1", "CH2",   "CH3",    "FH1",   "FH2",    "FH3", "LLID", "RLID",
                                 "MH",  "MNOSE", "LNSTRL", "TNOSE", "RNSTRL", "LHD", "RHD"};
  for (const char* side : {"L", "R"}) {
    for (int i = 1; i <= 8; ++i) expected.insert(std::string(side).append("C").append(std::to_string(i)));
    for (int i = 0; i <= 3; ++i) expected.insert(std::string(side).append("BM").append(std::to_string(i)));
    for (int i = 1; i <= 4; ++i) expected.insert(std::string(side).append("BRO").append(std::to_string(i)));
  }
  for (int i = 1; i <= 8; ++i) expected.insert("Mou" + std::to_string(i));
  ASSERT_EQ(expected.size(), 55u);
  EXPECT_EQ(rig().marker_names.size(), 55u);
  EXPECT_EQ(std::set<std::string>(rig().marker_names.begin(), rig().marker_names.end()), expected);
}

TEST(BuiltinFace, HasTheAusOfTheFacsCore) {
  for (const char* name :
       {"AU1", "AU2", "AU4", "AU6", "AU7", "AU9", "AU10", "AU12", "AU14", "AU15", "AU16", "AU20", "AU24", "AU45"}) {
    EXPECT_NE(face().find_au(std::string(name) + "L"), nullptr) << name;
    EXPECT_NE(face().find_au(std::string(name) + "R"), nullptr) << name;
  }
  for (const char* name : {"AU17", "AU18", "AU22", "AU27"}) EXPECT_NE(face().find_au(name), nullptr) << name;
}

TEST(BuiltinFace, AmplitudesArePlausible) {
  const auto at_marker = [](const char* au_name, const char* marker) {
    const auto m = std::find(rig().marker_names.begin(), rig().marker_names.end(), marker) - rig().marker_names.begin();
    for (const RigAu& au : rig().aus) {
      if (au.name == au_name) return Eigen::Vector3d(au.displacement_mm.col(m));
    }
    throw std::runtime_error(au_name);
  };
  // Millimetres of strong actions: brow 8, lip corner 12, chin 30 (the shapes' own design values).
  EXPECT_NEAR(at_marker("AU1L", "LBRO1").y(), 8, 1.5);
  EXPECT_NEAR(at_marker("AU12L", "Mou5").norm(), 12.5, 1.5);
  EXPECT_GT(at_marker("AU12L", "Mou5").x(), 5);
  EXPECT_LT(at_marker("AU12R", "Mou1").x(), -5);
  EXPECT_NEAR(at_marker("AU27", "CH2").norm(), 30, 3);
  EXPECT_LT(at_marker("AU27", "Mou3").norm(), 1);
  EXPECT_LT(at_marker("AU15L", "Mou5").y(), -6);
  EXPECT_LT(at_marker("AU45L", "LLID").y(), -8);
}

TEST(BuiltinFace, ShapesAreSmoothAndLocal) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  for (const FaceAu& au : face().aus()) {
    double moved = 0;
    for (Eigen::Index i = 0; i < v.cols(); ++i) moved += au.displacement_mm.col(i).norm() > 0.05;
    EXPECT_GT(moved, 20) << au.name;
    EXPECT_LT(moved / static_cast<double>(v.cols()), au.name == "AU27" ? 0.5 : 0.3) << au.name;
    // No edge is torn: the field changes by less than 1.5 mm per mm of skin, the jaw's lips (which part) by less
    // than 4.
    for (Eigen::Index t = 0; t < face().triangles().cols(); ++t) {
      const int a = face().triangles()(0, t), b = face().triangles()(1, t);
      const double change_mm = (au.displacement_mm.col(a) - au.displacement_mm.col(b)).norm();
      ASSERT_LT(change_mm, (au.name == "AU27" ? 4 : 1.5) * (v.col(a) - v.col(b)).norm()) << au.name;
    }
  }
}

TEST(BuiltinFace, ShapesAreContinuousBetweenVertices) {
  const std::size_t count = builtin_au_names().size();
  for (std::size_t k = 0; k < count; ++k) {
    for (double x = -70; x <= 70; x += 3.7) {
      for (double y = -90; y <= 110; y += 4.3) {
        const Eigen::Vector3d p(x, y, 90), step(1e-5, -1e-5, 1e-5);
        EXPECT_LT((builtin_displacement_mm(k, p + step) - builtin_displacement_mm(k, p)).norm(), 1e-4) << k;
      }
    }
  }
}

TEST(BuiltinFace, MarkersTellTheAusApart) {
  const Eigen::MatrixXd basis = unit_basis();
  const Eigen::MatrixXd cosine = basis.transpose() * basis;
  double largest = 0;
  std::string pair;
  for (Eigen::Index a = 0; a < cosine.rows(); ++a) {
    for (Eigen::Index b = a + 1; b < cosine.cols(); ++b) {
      if (std::abs(cosine(a, b)) <= largest) continue;
      largest = std::abs(cosine(a, b));
      pair = rig().aus[static_cast<std::size_t>(a)].name + " " + rig().aus[static_cast<std::size_t>(b)].name;
    }
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(basis);
  const double condition = svd.singularValues()[0] / svd.singularValues().tail(1)[0];
  std::printf("[ measured ] %td AUs, condition %.1f, largest |cosine| %.3f (%s)\n", basis.cols(), condition, largest,
              pair.c_str());
  EXPECT_LT(largest, 0.95);  // above, two AUs are one to these markers
  EXPECT_LT(condition, 30);  // 0.2 mm of noise stays below a tenth of a typical shape (8 mm)
}

TEST(BuiltinFace, EveryAuIsSeenByAMarker) {
  for (const RigAu& au : rig().aus) EXPECT_GT(au.displacement_mm.colwise().norm().maxCoeff(), 2) << au.name;
}

TEST(BuiltinFace, StabilisersHardlyMove) {
  EXPECT_EQ((rig().stabiliser_weight.array() > 0).count(), 7);
  for (Eigen::Index m = 0; m < rig().stabiliser_weight.size(); ++m) {
    if (rig().stabiliser_weight[m] == 0) continue;
    for (const RigAu& au : rig().aus) {
      EXPECT_LT(au.displacement_mm.col(m).norm(), 3)
          << rig().marker_names[static_cast<std::size_t>(m)] << " " << au.name;
    }
  }
}

}  // namespace
