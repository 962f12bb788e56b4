#include "solve/faces/rig_fit.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "capture/errors.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/face_identity.h"

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

LandmarkMap map55() { return find_landmark_map("iemocap55"); }

Eigen::Matrix3Xd moved(const Eigen::Quaterniond& rotation, double scale, const Eigen::Vector3d& translation) {
  return (scale * rotation.toRotationMatrix() * rig().neutral_mm).colwise() + translation;
}

std::string refusal_of(const Eigen::Matrix3Xd& neutral_mm, const LandmarkMap& map, const RigFitOptions& options = {}) {
  try {
    fit_rig(face(), rig().marker_names, neutral_mm, map, options);
  } catch (const UserError& error) {
    return error.what();
  }
  return "fitted";
}

TEST(RigFit, GivesTheBuiltinRigBackFromItsOwnMarkers) {
  const RigFitResult fit = fit_rig(face(), rig().marker_names, rig().neutral_mm, map55());
  EXPECT_NEAR(fit.scale, 1, 1e-9);
  EXPECT_LT(fit.median_distance_mm, 1e-9);
  EXPECT_TRUE(fit.dropped_aus.empty());
  EXPECT_EQ(fit.rig.marker_names, rig().marker_names);
  EXPECT_LT((fit.rig.neutral_mm - rig().neutral_mm).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(fit.rig.stabiliser_weight, rig().stabiliser_weight);
  ASSERT_EQ(fit.rig.au_count(), rig().au_count());
  for (std::size_t k = 0; k < rig().au_count(); ++k) {
    EXPECT_EQ(fit.rig.aus[k].name, rig().aus[k].name);
    EXPECT_LT((fit.rig.aus[k].displacement_mm - rig().aus[k].displacement_mm).cwiseAbs().maxCoeff(), 1e-6)
        << rig().aus[k].name;
  }
}

TEST(RigFit, ScalesFaceAndShapesToTheActorAnywhereInTheRoom) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 1, 0.1).normalized()));
  const Eigen::Vector3d translation(300, 1500, -200);
  const RigFitResult fit = fit_rig(face(), rig().marker_names, moved(rotation, 1.1, translation), map55());
  EXPECT_NEAR(fit.scale, 1.1, 1e-6);
  EXPECT_LT((fit.rig.neutral_mm - 1.1 * rig().neutral_mm).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((fit.rig.aus[5].displacement_mm - 1.1 * rig().aus[5].displacement_mm).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT(fit.head_from_world.rotation.angularDistance(rotation.conjugate()), 1e-6);
  const Eigen::Vector3d origin = fit.head_from_world * translation;
  EXPECT_LT(origin.norm(), 1e-4);
}

TEST(RigFit, SurvivesMarkersOffTheSkin) {
  Eigen::Matrix3Xd neutral = rig().neutral_mm;
  for (Eigen::Index m = 0; m < neutral.cols(); ++m)
    neutral.col(m) += 4 * neutral.col(m).normalized();  // balls on the skin
  neutral.col(20) += Eigen::Vector3d(0, 0, 40);         // one came loose
  const RigFitResult fit = fit_rig(face(), rig().marker_names, neutral, map55());
  EXPECT_LT(fit.median_distance_mm, 4);
  EXPECT_NEAR(fit.scale, 1.03, 0.04);  // 4 mm on a radius of about 110
  EXPECT_GT(*std::max_element(fit.rig.fit_distance_mm.begin(), fit.rig.fit_distance_mm.end()), 25);
  const Eigen::Quaterniond turned = fit.head_from_world.rotation;
  EXPECT_LT(turned.angularDistance(Eigen::Quaterniond::Identity()), 0.05);
}

/// Energy of what the rig's AUs differ from the truth's, over the truth's.
double wrong_share(const Rig& fitted, const Rig& truth) {
  double wrong = 0, all = 0;
  for (const RigAu& au : fitted.aus) {
    const auto of_truth = std::ranges::find(truth.aus, au.name, &RigAu::name);
    if (of_truth == truth.aus.end()) continue;
    wrong += (au.displacement_mm - of_truth->displacement_mm).squaredNorm();
    all += of_truth->displacement_mm.squaredNorm();
  }
  return wrong / all;
}

TEST(RigFit, BendsTheFaceTowardsWhoeverElseItIs) {
  double generic = 0, bent = 0;
  RigFitOptions without;
  without.with_identity = false;
  for (std::uint64_t person = 1; person <= 4; ++person) {
    const Rig truth = builtin_rig_of(builtin_face(face_identity_of_seed(person)));
    const RigFitResult g = fit_rig(face(), truth.marker_names, truth.neutral_mm, map55(), without);
    const RigFitResult b = fit_rig(face(), truth.marker_names, truth.neutral_mm, map55());
    EXPECT_EQ(g.identity_rms_mm, 0);
    EXPECT_GT(b.identity_rms_mm, 0.1) << person;
    EXPECT_LT(b.median_distance_mm, 0.7 * b.generic_median_distance_mm) << person;
    EXPECT_EQ(b.generic_median_distance_mm, g.median_distance_mm) << person;
    EXPECT_EQ(b.landmark_rms_mm, g.landmark_rms_mm) << "told of the generic face, whose fit is judged by it";
    generic += wrong_share(g.rig, truth);
    bent += wrong_share(b.rig, truth);
  }
  EXPECT_LT(bent, 0.9 * generic) << "of the energy of the AUs' displacements";
}

TEST(RigFit, RefusesWhatABentFaceWouldComeCloseTo) {
  Eigen::Matrix3Xd crumpled = rig().neutral_mm;
  for (Eigen::Index m = 0; m < crumpled.cols(); ++m) crumpled.col(m) *= m % 2 == 0 ? 1.1 : 0.9;
  RigFitOptions options;
  options.identity.deviation_mm = 1000;
  const RigFitResult fit = fit_rig(face(), rig().marker_names, crumpled, map55(), options);
  ASSERT_LT(fit.median_distance_mm, 0.8 * fit.generic_median_distance_mm);
  options.largest_median_mm = 0.9 * fit.generic_median_distance_mm;
  EXPECT_NE(refusal_of(crumpled, map55(), options).find("off the skin in the median"), std::string::npos)
      << refusal_of(crumpled, map55(), options);
  options.skin_deviation_mm = 0;
  EXPECT_THROW(fit_rig(face(), rig().marker_names, rig().neutral_mm, map55(), options), std::invalid_argument);
}

TEST(RigFit, IsDeterministic) {
  const RigFitResult a = fit_rig(face(), rig().marker_names, 1.05 * rig().neutral_mm, map55());
  const RigFitResult b = fit_rig(face(), rig().marker_names, 1.05 * rig().neutral_mm, map55());
  EXPECT_EQ(a.rig.neutral_mm, b.rig.neutral_mm);
  EXPECT_EQ(a.rig.aus[3].displacement_mm, b.rig.aus[3].displacement_mm);
}

TEST(RigFit, RefusesAMirroredNeutral) {
  Eigen::Matrix3Xd neutral = rig().neutral_mm;
  neutral.row(0) *= -1;
  EXPECT_NE(refusal_of(neutral, map55()).find("mirrored"), std::string::npos) << refusal_of(neutral, map55());
}

TEST(RigFit, RefusesAMapWithExchangedLandmarks) {
  LandmarkMap map = map55();
  std::swap(map.marker_of_landmark["chin"], map.marker_of_landmark["nose_bridge"]);
  EXPECT_NE(refusal_of(rig().neutral_mm, map), "fitted");
  map = map55();
  std::swap(map.marker_of_landmark["mouth_corner_left"], map.marker_of_landmark["mouth_corner_right"]);
  EXPECT_NE(refusal_of(rig().neutral_mm, map).find("mouth_corner"), std::string::npos)
      << refusal_of(rig().neutral_mm, map);
}

TEST(RigFit, RefusesLandmarksThatCannotTellLeftFromRight) {
  LandmarkMap map = map55();
  std::erase_if(map.marker_of_landmark, [](const auto& pair) {
    return pair.first.find("left") != std::string::npos || pair.first.find("right") != std::string::npos;
  });
  ASSERT_GE(map.marker_of_landmark.size(), 4u);
  Eigen::Matrix3Xd mirrored = rig().neutral_mm;
  mirrored.row(0) *= -1;
  EXPECT_NE(refusal_of(mirrored, map).find("map one at a side"), std::string::npos) << refusal_of(mirrored, map);
}

TEST(RigFit, LeavesOutAMarkerFarOffTheSkinAndIsNotBentByIt) {
  const auto cheek =
      std::find(rig().marker_names.begin(), rig().marker_names.end(), "LC5") - rig().marker_names.begin();
  const Rig truth = builtin_rig_of(builtin_face(face_identity_of_seed(3)));
  Eigen::Matrix3Xd neutral = truth.neutral_mm;
  Eigen::Matrix3Xd without = neutral;
  neutral.col(cheek) += Eigen::Vector3d(0, 0, 300);
  without.col(cheek).setConstant(std::numeric_limits<double>::quiet_NaN());
  const RigFitResult fit = fit_rig(face(), truth.marker_names, neutral, map55());
  const RigFitResult expected = fit_rig(face(), truth.marker_names, without, map55());
  EXPECT_EQ(fit.left_out_markers, std::vector<std::string>{"LC5"});
  ASSERT_FALSE(fit.warnings.empty());
  EXPECT_NE(fit.warnings[0].find("LC5 is 265 mm off"), std::string::npos) << fit.warnings[0];
  ASSERT_EQ(fit.rig.au_count(), expected.rig.au_count());
  // But for where the iterations of closest points end.
  EXPECT_LT((fit.rig.neutral_mm - expected.rig.neutral_mm).norm(), 1e-3);
  const Eigen::Matrix3Xd& field_mm = expected.rig.aus[3].displacement_mm;
  EXPECT_LT((fit.rig.aus[3].displacement_mm - field_mm).norm(), 0.005 * field_mm.norm());
}

TEST(RigFit, AHeadbandFarOffTheSkinStaysWhereTheMapNamesIt) {
  std::vector<std::string> names = rig().marker_names;
  Eigen::Matrix3Xd neutral = rig().neutral_mm;
  names.emplace_back("band");
  neutral.conservativeResize(3, neutral.cols() + 1);
  neutral.rightCols(1) = Eigen::Vector3d(0, 200, 120);
  LandmarkMap map = map55();
  map.stabiliser_weight["band"] = 1;
  const RigFitResult fit = fit_rig(face(), names, neutral, map);
  EXPECT_TRUE(fit.left_out_markers.empty());
  EXPECT_EQ(fit.rig.stabiliser_weight.tail(1)[0], 1);
  EXPECT_LT(fit.identity_rms_mm, 1e-3) << "of a face that is the generic one";
}

TEST(RigFit, NamesTheLandmarkThatIsFarOff) {
  const std::string chin = map55().marker_of_landmark.at("chin");
  Eigen::Matrix3Xd neutral = rig().neutral_mm;
  neutral.col(std::find(rig().marker_names.begin(), rig().marker_names.end(), chin) - rig().marker_names.begin()) +=
      Eigen::Vector3d(0, 0, 500);
  EXPECT_NE(refusal_of(neutral, map55()).find("chin"), std::string::npos) << refusal_of(neutral, map55());
}

TEST(RigFit, RefusesFewerThanFourLandmarks) {
  LandmarkMap map = map55();
  while (map.marker_of_landmark.size() > 3) map.marker_of_landmark.erase(map.marker_of_landmark.begin());
  EXPECT_NE(refusal_of(rig().neutral_mm, map).find("only 3 of 3 landmarks"), std::string::npos);
  map = map55();
  for (auto& [landmark, marker] : map.marker_of_landmark) marker = "unknown";
  EXPECT_NE(refusal_of(rig().neutral_mm, map).find("only 0 of 11 landmarks"), std::string::npos);
}

TEST(RigFit, RefusesAnotherUnitAndAHeadOnItsSide) {
  EXPECT_NE(refusal_of(0.1 * rig().neutral_mm, map55()).find("check the unit"), std::string::npos);
  const Eigen::Matrix3Xd lying =
      moved(Eigen::Quaterniond(Eigen::AngleAxisd(1.5708, Eigen::Vector3d::UnitX())), 1, {0, 0, 0});
  EXPECT_NE(refusal_of(lying, map55()).find("90 degrees"), std::string::npos);
  RigFitOptions options;
  options.largest_tilt_degrees = 180;
  EXPECT_EQ(refusal_of(lying, map55(), options), "fitted");
}

TEST(RigFit, RefusesLandmarksInOnePoint) {
  const Eigen::Matrix3Xd neutral = Eigen::Matrix3Xd::Constant(3, 55, 7);
  EXPECT_NE(refusal_of(neutral, map55()).find("one point"), std::string::npos);
}

TEST(RigFit, LeavesOutMarkersThatWereNeverSeen) {
  Eigen::Matrix3Xd neutral = rig().neutral_mm;
  const auto lost = std::find(rig().marker_names.begin(), rig().marker_names.end(), "LC5") - rig().marker_names.begin();
  neutral(1, lost) = std::numeric_limits<double>::quiet_NaN();
  const RigFitResult fit = fit_rig(face(), rig().marker_names, neutral, map55());
  EXPECT_EQ(fit.left_out_markers, std::vector<std::string>{"LC5"});
  EXPECT_EQ(fit.rig.marker_count(), 54u);
  EXPECT_EQ(std::count(fit.rig.marker_names.begin(), fit.rig.marker_names.end(), "LC5"), 0);
  EXPECT_EQ(fit.rig.neutral_mm.cols(), 54);
  EXPECT_EQ(fit.places.size(), 54u);
}

TEST(RigFit, DropsAusThatNoMarkerSees) {
  std::vector<std::string> names;
  Eigen::Matrix3Xd neutral(3, 0);
  for (std::size_t m = 0; m < rig().marker_count(); ++m) {
    const Eigen::Vector3d p = rig().neutral_mm.col(static_cast<Eigen::Index>(m));
    if (p.y() > 35 && p.y() < 70) continue;  // no brow, no lid
    names.push_back(rig().marker_names[m]);
    neutral.conservativeResize(3, neutral.cols() + 1);
    neutral.rightCols(1) = p;
  }
  const RigFitResult fit = fit_rig(face(), names, neutral, map55());
  EXPECT_NE(std::find(fit.dropped_aus.begin(), fit.dropped_aus.end(), "AU45L"), fit.dropped_aus.end());
  EXPECT_EQ(fit.rig.au_count() + fit.dropped_aus.size(), rig().au_count());
}

TEST(RigFit, ChoosesCalmSpreadStabilisersWhereTheMapNamesNone) {
  LandmarkMap map = map55();
  map.stabiliser_weight.clear();
  const RigFitResult fit = fit_rig(face(), rig().marker_names, rig().neutral_mm, map);
  const auto count = (fit.rig.stabiliser_weight.array() > 0).count();
  EXPECT_GE(count, 4);
  EXPECT_LE(count, 6);
  for (Eigen::Index m = 0; m < fit.rig.stabiliser_weight.size(); ++m) {
    if (fit.rig.stabiliser_weight[m] == 0) continue;
    for (const RigAu& au : fit.rig.aus) EXPECT_LT(au.displacement_mm.col(m).norm(), 3) << au.name;
  }
  const bool is_reported = std::any_of(fit.warnings.begin(), fit.warnings.end(),
                                       [](const std::string& w) { return w.find("chosen") != std::string::npos; });
  EXPECT_TRUE(is_reported);
}

TEST(RigFit, ChecksItsOptionsAndSizes) {
  RigFitOptions options;
  options.iterations = 0;
  EXPECT_THROW(fit_rig(face(), rig().marker_names, rig().neutral_mm, map55(), options), std::invalid_argument);
  EXPECT_THROW(fit_rig(face(), {"one"}, rig().neutral_mm, map55()), std::invalid_argument);
  std::vector<std::string> twice = rig().marker_names;
  twice[1] = twice[0];
  EXPECT_THROW(fit_rig(face(), twice, rig().neutral_mm, map55()), UserError);
}

}  // namespace
