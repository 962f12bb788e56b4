#include "solve/faces/builtin_face.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "solve/faces/builtin_head_mesh.h"
#include "solve/faces/builtin_head_surface.h"
#include "solve/faces/face_checks.h"
#include "solve/faces/facial_muscles.h"

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

Eigen::Vector3d mirrored(const Eigen::Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

/// One column per AU of the rig but one, unit length.
Eigen::MatrixXd unit_basis(std::string_view without) {
  Eigen::MatrixXd basis(3 * static_cast<Eigen::Index>(rig().marker_count()),
                        static_cast<Eigen::Index>(rig().au_count()) - 1);
  Eigen::Index column = 0;
  for (const RigAu& au : rig().aus) {
    if (au.name != without) basis.col(column++) = au.displacement_mm.reshaped().normalized();
  }
  return basis;
}

Eigen::Vector3d landmark(const char* name) { return face().position_mm(*face().find_landmark(name)); }

Eigen::Vector3d place_in(const FaceModel& model, const char* layout, const std::string& name,
                         const Eigen::Matrix3Xd& field) {
  for (const NamedPlace& place : *model.find_layout(layout)) {
    if (place.name == name) return model.at(field, place.place);
  }
  throw std::runtime_error(name);
}

TEST(BuiltinFace, HasTheProportionsOfAFace) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  EXPECT_GE(v.cols(), 5000);
  EXPECT_LE(v.cols(), 12000);
  // Adults' means (Farkas 1994): nasion to menton 120, nose 50, mouth 50, bizygomatic 135, pupils 63 apart.
  EXPECT_NEAR(landmark("nose_bridge").y() - landmark("chin").y(), 118, 6);
  EXPECT_NEAR(landmark("nose_bridge").y() - place_in(face(), "ibug68", "33", v).y(), 50, 3);
  EXPECT_NEAR(landmark("mouth_corner_left").x() - landmark("mouth_corner_right").x(), 51, 2);
  EXPECT_NEAR(place_in(face(), "ibug68", "15", v).x() - place_in(face(), "ibug68", "1", v).x(), 135, 6);
  const double eye_middle = 0.5 * (landmark("eye_inner_left").x() + landmark("eye_outer_left").x());
  EXPECT_NEAR(2 * eye_middle, 63, 2);
  Eigen::Index foremost = 0;
  v.row(2).maxCoeff(&foremost);
  EXPECT_LT((v.col(foremost) - landmark("nose_tip")).norm(), 5);
}

TEST(BuiltinFace, IsOpenOnlyWhereItIsMeantToBe) {
  // An edge used once in each direction joins two triangles; used once only it is the border of an opening.
  std::map<std::pair<int, int>, int> uses;
  const auto& triangles = face().triangles();
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    for (int k = 0; k < 3; ++k) ++uses[{triangles(k, t), triangles((k + 1) % 3, t)}];
  }
  std::map<int, int> next;  // along the borders
  for (const auto& [edge, count] : uses) {
    ASSERT_EQ(count, 1) << edge.first << " " << edge.second;
    const bool is_border = !uses.contains({edge.second, edge.first});
    ASSERT_TRUE(!is_border || next.emplace(edge.second, edge.first).second);
  }
  int loops = 0;
  while (!next.empty()) {
    ++loops;
    for (auto at = next.begin(); at != next.end();) {
      const int to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  // The neck; two lid rims; two eyeballs' backs; two bows of teeth. The mouth is a closed pocket.
  EXPECT_EQ(loops, 7);
}

TEST(BuiltinFace, IsItsOwnMirrorImage) { EXPECT_LE(test::largest_asymmetry_mm(face()), 1e-9); }

TEST(BuiltinFace, NeitherCutsNorFoldsUnderAnyAu) {
  const test::Integrity integrity = test::integrity_of(face());
  EXPECT_EQ(integrity.intersections_at_one, 0);
  EXPECT_EQ(integrity.intersections_at_bound, 0);
  EXPECT_EQ(integrity.flipped, 0);
}

TEST(BuiltinFace, LidsMeetAtABlinkAndLeaveTheCornersInPlace) {
  const double gap_mm = test::largest_lid_gap_mm(face());
  EXPECT_GT(gap_mm, 0);  // a crossing is negative
  EXPECT_LE(gap_mm, 1);
  const FaceAu& blink = *face().find_au("AU45L");
  EXPECT_LT(face().at(blink.displacement_mm, *face().find_landmark("eye_inner_left")).norm(), 0.5);
  EXPECT_LT(face().at(blink.displacement_mm, *face().find_landmark("eye_outer_left")).norm(), 0.5);
}

TEST(BuiltinFace, LidsSlideOverTheEyeball) {
  const HeadMesh mesh = build_head_mesh();
  for (const char* name : {"AU5L", "AU7L", "AU45L"}) {
    const Eigen::Matrix3Xd moved = face().vertices_mm() + face().find_au(name)->displacement_mm;
    for (const auto& edge : {mesh.upper_lid_edge, mesh.lower_lid_edge}) {
      for (const int v : edge) {
        const Eigen::Vector3d from_middle = moved.col(v) - head::kEyeballMm;
        if (from_middle.head<2>().norm() > 9.5) continue;  // towards the corners the lids leave the eyeball
        EXPECT_NEAR(from_middle.norm(), head::kEyeballRadiusMm + head::kLidOverEyeballMm, 1) << name;
      }
    }
  }
}

TEST(BuiltinFace, LipsTouchAtRestAndPart) {
  const HeadMesh mesh = build_head_mesh();
  const auto opening_mm = [&](const char* au) {
    Eigen::Matrix3Xd v = face().vertices_mm();
    if (au != nullptr) v += face().find_au(au)->displacement_mm;
    const std::size_t middle = mesh.upper_lip_edge.size() / 2;
    return v(1, mesh.upper_lip_edge[middle]) - v(1, mesh.lower_lip_edge[middle]);
  };
  EXPECT_GT(opening_mm(nullptr), 0);
  EXPECT_LT(opening_mm(nullptr), 0.1);
  EXPECT_GT(opening_mm("AU25"), 3);
  EXPECT_GT(opening_mm("AU27"), 20);
  EXPECT_GT(opening_mm("AU22"), 4);
  EXPECT_LT(opening_mm("AU12L"), 0.5);  // lips closed: no tooth shows
  EXPECT_LT(opening_mm("AU17"), 0.5);
  EXPECT_LT(opening_mm("AU18"), 0.5);
}

TEST(BuiltinFace, MovesTheSkinThatTheMusclesCarry) {
  for (const test::FaceCheck& check : test::face_checks()) {
    const FaceAu* au = face().find_au(check.column);
    ASSERT_NE(au, nullptr) << check.column;
    EXPECT_GT(test::share_inside(face(), *au, check.region), 0.8) << check.column;
    const auto cosine = test::cosine_with_muscle(face(), *au);
    // Where two muscles push skin apart or out (22, 24), the mean goes with neither.
    const bool is_judged = cosine && check.column != "AU22" && check.column != "AU24L";
    EXPECT_TRUE(!is_judged || *cosine > 0.7) << check.column;
  }
}

TEST(BuiltinFace, EveryMuscleServesAColumnAndPullsInItsRegion) {
  std::set<std::string_view> served;
  for (const AuColumn& column : facial_au_columns()) served.insert(column.au);
  for (const Muscle& muscle : facial_muscles()) {
    EXPECT_TRUE(served.contains(muscle.au)) << muscle.name;
    EXPECT_GT(muscle.along_mm, 5) << muscle.name;
    EXPECT_GT(muscle.across_mm, 5) << muscle.name;
    EXPECT_GE(muscle.insertion_mm.x(), 0) << muscle.name;
    EXPECT_EQ(muscle.is_paired, muscle.insertion_mm.x() > 0) << muscle.name;
  }
}

TEST(BuiltinFace, HasFourLayoutsOfMirroredPlacesOnTheSkin) {
  const std::map<std::string, std::size_t> sizes{
      {"iemocap55", 55}, {"animface41", 41}, {"bu4dfe83", 83}, {"ibug68", 68}};
  for (const auto& [name, size] : sizes) {
    const auto* layout = face().find_layout(name);
    ASSERT_NE(layout, nullptr) << name;
    std::set<std::string> names;
    Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(layout->size()));
    for (std::size_t k = 0; k < layout->size(); ++k) {
      names.insert((*layout)[k].name);
      p.col(static_cast<Eigen::Index>(k)) = face().position_mm((*layout)[k].place);
      EXPECT_LT((*layout)[k].place.triangle, face().skin_triangle_count());
    }
    EXPECT_EQ(names.size(), size) << name;
    for (Eigen::Index a = 0; a < p.cols(); ++a) {
      const double nearest_mm = (p.colwise() - mirrored(p.col(a))).colwise().norm().minCoeff();
      EXPECT_LT(nearest_mm, 0.01) << name << " " << (*layout)[static_cast<std::size_t>(a)].name;
      // No two markers on one spot.
      for (Eigen::Index b = 0; b < a; ++b) EXPECT_GT((p.col(a) - p.col(b)).norm(), 0.5) << name << " " << a << " " << b;
    }
  }
}

TEST(BuiltinFace, NumbersItsLandmarksAsTheFieldDoes) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  const auto at = [&](int number) { return place_in(face(), "ibug68", std::to_string(number), v); };
  EXPECT_LT(at(0).x(), -50);  // the subject's right ear first
  EXPECT_GT(at(16).x(), 50);
  EXPECT_LT(at(48).x(), 0);
  EXPECT_GT(at(54).x(), 0);
  EXPECT_LT(at(36).x(), at(39).x());  // right eye: outer corner, then inner
  EXPECT_LT(at(42).x(), at(45).x());
  EXPECT_GT(at(37).y(), at(41).y());
  EXPECT_GT(at(62).y(), at(66).y());
  for (int k = 0; k < 8; ++k) EXPECT_LT(at(k).x(), at(k + 1).x());
  for (int k = 17; k < 26; ++k) EXPECT_LT(at(k).x(), at(k + 1).x());
  for (int k = 48; k < 54; ++k) EXPECT_LT(at(k).x(), at(k + 1).x());
  for (int k = 54; k < 59; ++k) EXPECT_GT(at(k).x(), at(k + 1).x());
  const auto bu = [&](const char* name) { return place_in(face(), "bu4dfe83", name, v); };
  EXPECT_GT(bu("left_eye_1").x(), bu("left_eye_5").x());
  EXPECT_LT(bu("right_eye_1").x(), bu("right_eye_5").x());
  EXPECT_LT(bu("mouth_outer_1").x(), bu("mouth_outer_7").x());
  EXPECT_LT(bu("contour_8").y(), bu("contour_1").y());
}

TEST(BuiltinFace, IdentitiesDifferAndStayWhole) {
  const Eigen::Matrix3Xd average = face().vertices_mm();
  EXPECT_EQ(builtin_face(face_identity_of_seed(0)).vertices_mm(), average);
  for (const std::uint64_t seed : {1, 17}) {
    const FaceModel other = builtin_face(face_identity_of_seed(seed));
    EXPECT_EQ(other.vertices_mm(), builtin_face(face_identity_of_seed(seed)).vertices_mm());
    EXPECT_GT((other.vertices_mm() - average).colwise().norm().mean(), 0.5) << seed;
    EXPECT_LE(test::largest_asymmetry_mm(other), 1e-9) << seed;
    const test::Integrity integrity = test::integrity_of(other, false);
    EXPECT_EQ(integrity.intersections_at_bound, 0) << seed;
    EXPECT_EQ(integrity.flipped, 0) << seed;
    EXPECT_GT(test::largest_lid_gap_mm(other), 0) << seed;
    EXPECT_LE(test::largest_lid_gap_mm(other), 1) << seed;
  }
}

TEST(BuiltinFace, EachIdentityParameterDoesWhatItsNameSays) {
  const auto changed = [](double FaceIdentity::*parameter, double value, const char* place, int axis) {
    FaceIdentity identity;
    identity.*parameter = value;
    const FaceModel other = builtin_face(identity);
    return place_in(other, "ibug68", place, other.vertices_mm())[axis] -
           place_in(face(), "ibug68", place, face().vertices_mm())[axis];
  };
  EXPECT_NEAR(changed(&FaceIdentity::eye_spacing_mm, 4, "42", 0), 2, 0.3);
  EXPECT_LT(changed(&FaceIdentity::nose_length_mm, 3, "30", 1), -2.5);
  EXPECT_GT(changed(&FaceIdentity::nose_width, 0.2, "35", 0), 1);
  EXPECT_GT(changed(&FaceIdentity::jaw_width, 0.1, "12", 0), 3);
  EXPECT_GT(changed(&FaceIdentity::brow_depth_mm, 2, "24", 2), 1);
  EXPECT_LT(changed(&FaceIdentity::lip_fullness_mm, 2, "57", 1), -0.8);
  EXPECT_GT(changed(&FaceIdentity::chin_forward_mm, 4, "8", 2), 2);
  EXPECT_LT(changed(&FaceIdentity::face_height, 0.05, "8", 1), -3);
  EXPECT_GT(changed(&FaceIdentity::face_width, 0.05, "16", 0), 2.5);
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
  for (const char* name : {"AU1", "AU2", "AU4", "AU5", "AU6", "AU7", "AU9", "AU10", "AU12", "AU13", "AU14", "AU15",
                           "AU16", "AU20", "AU24", "AU30", "AU34", "AU45"}) {
    EXPECT_NE(face().find_au(std::string(name) + "L"), nullptr) << name;
    EXPECT_NE(face().find_au(std::string(name) + "R"), nullptr) << name;
  }
  for (const char* name : {"AU17", "AU18", "AU22", "AU23", "AU25", "AU27", "AU28", "AU29"}) {
    EXPECT_NE(face().find_au(name), nullptr) << name;
  }
}

TEST(BuiltinFace, AmplitudesArePlausible) {
  const auto at_marker = [](const char* au_name, const char* marker) {
    const auto m = std::find(rig().marker_names.begin(), rig().marker_names.end(), marker) - rig().marker_names.begin();
    for (const RigAu& au : rig().aus) {
      if (au.name == au_name) return Eigen::Vector3d(au.displacement_mm.col(m));
    }
    throw std::runtime_error(au_name);
  };
  // The muscle table's own amplitudes; compared with ICT-FaceKit's in tests/bench/bench_face.cpp.
  EXPECT_NEAR(at_marker("AU1L", "LBRO1").y(), 6.2, 1);
  EXPECT_NEAR(at_marker("AU12L", "Mou5").norm(), 13, 1);
  EXPECT_GT(at_marker("AU12L", "Mou5").x(), 4);
  EXPECT_LT(at_marker("AU12R", "Mou1").x(), -4);
  EXPECT_NEAR(at_marker("AU27", "CH2").norm(), 34, 4);
  EXPECT_LT(at_marker("AU27", "Mou3").norm(), 1);
  EXPECT_LT(at_marker("AU15L", "Mou5").y(), -5);
  EXPECT_LT(at_marker("AU45L", "LLID").y(), -5);
  EXPECT_GT(at_marker("AU5L", "LLID").y(), 1.5);
}

TEST(BuiltinFace, ShapesAreSmoothAndLocal) {
  const Eigen::Matrix3Xd& v = face().vertices_mm();
  for (const FaceAu& au : face().aus()) {
    double moved = 0;
    for (Eigen::Index i = 0; i < v.cols(); ++i) moved += au.displacement_mm.col(i).norm() > 0.05;
    EXPECT_GT(moved, 20) << au.name;
    const bool is_jaw = au.name == "AU27" || au.name == "AU29" || au.name.starts_with("AU30");
    EXPECT_LT(moved / static_cast<double>(v.cols()), is_jaw ? 0.6 : 0.4) << au.name;
    // No edge of the skin is torn: the field changes by less than 1.6 mm per mm of skin; the jaw's lips, which part
    // from the corner on, by less than 4.
    for (int t = 0; t < face().skin_triangle_count(); ++t) {
      const int a = face().triangles()(0, t), b = face().triangles()(1, t);
      const double change_mm = (au.displacement_mm.col(a) - au.displacement_mm.col(b)).norm();
      ASSERT_LT(change_mm, (is_jaw ? 4 : 1.6) * (v.col(a) - v.col(b)).norm() + 0.05) << au.name;
    }
  }
}

TEST(BuiltinFace, MarkersTellTheAusApart) {
  // The jaw to the right is the jaw to the left backwards: one of the two is enough here, bounds keep them apart.
  const Eigen::MatrixXd basis = unit_basis("AU30R");
  std::vector<std::string> names = rig().au_names();
  std::erase(names, "AU30R");
  const Eigen::MatrixXd cosine = basis.transpose() * basis;
  double largest = 0;
  std::string pair;
  for (Eigen::Index a = 0; a < cosine.rows(); ++a) {
    for (Eigen::Index b = a + 1; b < cosine.cols(); ++b) {
      if (std::abs(cosine(a, b)) <= largest) continue;
      largest = std::abs(cosine(a, b));
      pair = names[static_cast<std::size_t>(a)] + " " + names[static_cast<std::size_t>(b)];
    }
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(basis);
  const double condition = svd.singularValues()[0] / svd.singularValues().tail(1)[0];
  std::printf("[ measured ] %td AUs, condition %.1f, largest |cosine| %.3f (%s)\n", basis.cols(), condition, largest,
              pair.c_str());
  EXPECT_LT(largest, 0.95);  // above, two AUs are one to these markers
  EXPECT_LT(condition, 40);  // ICT-FaceKit's shapes have 34.6 at an actor's 41 markers
}

TEST(BuiltinFace, EveryAuIsSeenByAMarker) {
  for (const RigAu& au : rig().aus) EXPECT_GT(au.displacement_mm.colwise().norm().maxCoeff(), 1.2) << au.name;
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
