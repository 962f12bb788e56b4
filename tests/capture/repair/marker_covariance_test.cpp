#include "capture/repair/marker_covariance.h"

#include <gtest/gtest.h>

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
  EXPECT_THROW(MarkerCovariance({.alone_mm = std::nan("")}), UserError);
  EXPECT_THROW(MarkerCovariance({.prior_samples = 0}), UserError);
}

}  // namespace
}  // namespace risorius
