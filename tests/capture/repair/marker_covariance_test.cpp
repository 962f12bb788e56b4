#include "capture/repair/marker_covariance.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "capture/errors.h"
#include "support/linear_face.h"

namespace risorius {
namespace {

using test::LinearFace;
constexpr double kStepS = 1.0 / 60;

MarkerCovariance learnt(LinearFace& face, int frames) {
  MarkerCovariance covariance;
  covariance.remap(std::vector<int>(LinearFace::kMarkers, -1));
  for (int f = 0; f < frames; ++f) {
    face.next();
    covariance.observe(face.measured, face.visible);
    covariance.learn(kStepS);
  }
  return covariance;
}

TEST(MarkerCovariance, PredictsHiddenMarkersFromTheOthers) {
  LinearFace face(1);
  MarkerCovariance covariance = learnt(face, 1000);
  double squared = 0;
  for (int f = 0; f < 200; ++f) {
    face.next();
    for (const std::size_t hidden : {4, 7}) {
      face.visible[hidden] = 0;
      face.measured[hidden].setConstant(std::nan(""));
    }
    covariance.observe(face.measured, face.visible);
    for (const std::size_t hidden : {4, 7}) {
      squared += (covariance.prediction_mm(hidden) - face.truth[hidden]).squaredNorm() / 400;
    }
  }
  EXPECT_LT(std::sqrt(squared), 0.12 * 7.3);  // a marker moves by about 3 * sqrt(2 * 3) = 7.3 mm
}

TEST(MarkerCovariance, LeaveOneOutPredictionEqualsThatOfTheMarkerHiddenWhileOthersAre) {
  LinearFace face(2);
  MarkerCovariance covariance = learnt(face, 333);
  face.next();
  face.visible[0] = 0;
  covariance.observe(face.measured, face.visible);
  for (const std::size_t i : {1, 3, 8}) {
    const Eigen::Vector3d left_out = covariance.prediction_mm(i);
    const double variance = covariance.variance_mm2(i);
    MarkerCovariance other = covariance;
    auto visible = face.visible;
    visible[i] = 0;
    other.observe(face.measured, visible);
    EXPECT_LT((other.prediction_mm(i) - left_out).norm(), 1e-8);
    EXPECT_NEAR(other.variance_mm2(i), variance, 1e-9 * variance);
  }
}

TEST(MarkerCovariance, SaysByHowMuchAHiddenMarkersPredictionFellWhenAnotherWentToo) {
  LinearFace face(3);
  MarkerCovariance covariance = learnt(face, 300);
  face.next();
  face.visible[5] = 0;
  covariance.observe(face.measured, face.visible);
  const Eigen::Vector3d before = covariance.prediction_mm(5), before_of_next = covariance.prediction_mm(6);
  face.visible[6] = 0;
  covariance.observe(face.measured, face.visible);  // the same frame once more
  ASSERT_TRUE(covariance.has_shifted());
  EXPECT_LT((covariance.prediction_mm(5) + covariance.shift_mm(5) - before).norm(), 1e-8);
  EXPECT_LT((covariance.prediction_mm(6) + covariance.shift_mm(6) - before_of_next).norm(), 1e-8);
  EXPECT_EQ(covariance.shift_mm(1).norm(), 0);
  covariance.observe(face.measured, face.visible);
  EXPECT_FALSE(covariance.has_shifted());
}

TEST(MarkerCovariance, BelievesThatNeighboursMoveAlikeBeforeItHasLearntAnything) {
  MarkerCovariance covariance;
  covariance.remap({-1, -1, -1, -1});
  std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {200, 0, 0}};
  std::vector<std::uint8_t> visible(4, 1);
  covariance.observe(positions, visible);
  covariance.learn(kStepS);
  for (std::size_t i : {1, 2}) positions[i].z() += 4;
  visible[0] = 0;
  covariance.observe(positions, visible);
  EXPECT_GT(covariance.prediction_mm(0).z(), 2);  // two neighbours, each of them half its own: 4 * 2 / 3, less a little
  EXPECT_LT(covariance.prediction_mm(0).z(), 3);
  visible[3] = 0;
  covariance.observe(positions, visible);
  EXPECT_LT(covariance.prediction_mm(3).z(), 0.1);
}

TEST(MarkerCovariance, AMarkerThatComesLateLeansOnItsNeighbours) {
  MarkerCovariance covariance;
  covariance.remap({-1, -1, -1, -1});
  std::vector<Eigen::Vector3d> positions{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {200, 0, 0}};
  std::vector<std::uint8_t> visible{0, 1, 1, 1};
  for (int f = 0; f < 30; ++f) {
    covariance.observe(positions, visible);
    covariance.learn(kStepS);
  }
  visible[0] = 1;
  covariance.observe(positions, visible);
  covariance.learn(kStepS);
  for (std::size_t i : {1, 2}) positions[i].z() += 4;
  visible[0] = 0;
  covariance.observe(positions, visible);
  EXPECT_GT(covariance.prediction_mm(0).z(), 2);
  EXPECT_LT(covariance.prediction_mm(0).z(), 3);
}

/// A face of which it is known that marker 0 moves along y when marker 5, far from it, moves along x; and in a mode of
/// their own markers 1 and 2 as one.
KnownMotion opposite_corners() {
  KnownMotion motion;
  motion.rest_mm.resize(3, 6);
  motion.rest_mm << -60, 60, 0, -60, 60, 80,  //
      60, 60, 0, -60, -60, 10,                //
      0, 0, 30, 0, 0, 20;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) motion.marker_names.emplace_back(name);
  motion.modes_mm.assign(2, Eigen::Matrix3Xd::Zero(3, 6));
  motion.modes_mm[0](1, 0) = motion.modes_mm[0](0, 5) = 20;
  motion.modes_mm[1](2, 1) = motion.modes_mm[1](2, 2) = 20;
  return motion;
}

TEST(MarkerCovariance, BelievesWhatIsKnownOfTheFaceInTheAxesInWhichItIsSeen) {
  const KnownMotion motion = opposite_corners();
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<Eigen::Vector3d> positions;
  for (Eigen::Index i = 0; i < 6; ++i) positions.push_back(turned * motion.rest_mm.col(i) + Eigen::Vector3d(9, 0, 300));
  std::vector<std::uint8_t> visible(6, 1);
  MarkerCovariance known, unknown;
  for (MarkerCovariance* covariance : {&known, &unknown}) covariance->remap(std::vector<int>(6, -1));
  known.know(std::make_shared<KnownMotion>(motion), motion.marker_names);
  for (MarkerCovariance* covariance : {&known, &unknown}) {
    covariance->observe(positions, visible);
    covariance->learn(kStepS);
  }
  const Eigen::Vector3d rest = positions[0];
  positions[5] += turned * Eigen::Vector3d(6, 0, 0);
  visible[0] = 0;
  for (MarkerCovariance* covariance : {&known, &unknown}) covariance->observe(positions, visible);
  const Eigen::Vector3d moved = turned.transpose() * (known.prediction_mm(0) - rest);
  EXPECT_GT(moved.y(), 4);  // 6 mm, less what the marker may do alone
  EXPECT_LT(moved.y(), 6);
  EXPECT_LT(std::abs(moved.x()) + std::abs(moved.z()), 0.5);
  EXPECT_LT((unknown.prediction_mm(0) - rest).norm(), 0.5);
}

TEST(MarkerCovariance, ANumberOfMarkersThatTheFaceDoesNotKnowBreaksNothing) {
  // Known markers that hardly move, among unknown ones that may: what is believed must remain a covariance.
  KnownMotion motion;
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::string> names;
  for (int i = 0; i < 40; ++i) {
    positions.emplace_back(7.0 * (i % 8), 7.0 * (i / 8), 0.05 * i * i);
    names.push_back("m" + std::to_string(i));
  }
  motion.rest_mm.resize(3, 20);
  for (int i = 0; i < 20; ++i) {
    motion.marker_names.push_back(names[static_cast<std::size_t>(2 * i)]);
    motion.rest_mm.col(i) = positions[static_cast<std::size_t>(2 * i)];
  }
  motion.modes_mm.assign(1, Eigen::Matrix3Xd::Zero(3, 20));
  motion.modes_mm[0].col(3).setConstant(10);
  MarkerCovariance covariance;
  covariance.remap(std::vector<int>(40, -1));
  covariance.know(std::make_shared<KnownMotion>(motion), names);
  std::vector<std::uint8_t> visible(40, 1);
  for (int f = 0; f < 30; ++f) {
    covariance.observe(positions, visible);
    covariance.learn(kStepS);
  }
  for (std::size_t i = 0; i < 40; ++i) {
    std::vector<std::uint8_t> without = visible;
    without[i] = 0;
    MarkerCovariance hidden = covariance;
    hidden.observe(positions, without);
    EXPECT_LT((hidden.prediction_mm(i) - positions[i]).norm(), 1e-6) << i;
    EXPECT_GT(hidden.variance_mm2(i), 0) << i;
  }
}

TEST(MarkerCovariance, StaysSoundOverManyFramesThatNeverChange) {
  LinearFace face(4);
  MarkerCovariance covariance = learnt(face, 100);
  for (int f = 0; f < 100'000; ++f) {  // 28 minutes at 60 Hz: nearly all of the beginning is forgotten
    covariance.observe(face.measured, face.visible);
    covariance.learn(kStepS);
  }
  face.visible[2] = 0;
  auto moved = face.measured;
  for (Eigen::Vector3d& p : moved) p.x() += 1;
  covariance.observe(moved, face.visible);
  EXPECT_LT((covariance.prediction_mm(2) - face.measured[2]).norm(), 3);
  EXPECT_GT(covariance.variance_mm2(2), 0);
  EXPECT_LT(covariance.variance_mm2(2), 4);
}

TEST(MarkerCovariance, KeepsWhatIsKnownOfMarkersThatRemainInTheSet) {
  LinearFace face(5);
  MarkerCovariance covariance = learnt(face, 500);
  std::vector<int> kept;
  for (int i = 0; i < 12; ++i) kept.push_back(11 - i);
  kept.push_back(-1);
  covariance.remap(kept);
  face.next();
  std::vector<Eigen::Vector3d> positions(face.measured.rbegin(), face.measured.rend());
  positions.push_back({0, 0, 0});
  std::vector<std::uint8_t> visible(13, 1);
  visible[3] = visible[12] = 0;
  covariance.observe(positions, visible);
  EXPECT_LT((covariance.prediction_mm(3) - face.truth[8]).norm(), 2);
  EXPECT_FALSE(covariance.seen(12));
}

TEST(MarkerCovariance, RejectsOptionsOutOfRange) {
  EXPECT_THROW(MarkerCovariance({.memory_s = 0}), UserError);
  EXPECT_THROW(MarkerCovariance({.rest_s = -1}), UserError);
  EXPECT_THROW(MarkerCovariance({.mode_strength = 0}), UserError);
  EXPECT_THROW(MarkerCovariance({.unknown_share = -0.1}), UserError);
  EXPECT_THROW(MarkerCovariance({.alone_mm = std::nan("")}), UserError);
  EXPECT_THROW(MarkerCovariance({.prior_samples = 0}), UserError);
}

}  // namespace
}  // namespace risorius
