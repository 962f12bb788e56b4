#include "capture/repair/marker_statistics.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/linear_face.h"

namespace risorius {
namespace {

using test::LinearFace;

MarkerStatistics learnt(LinearFace& face, int frames) {
  MarkerStatistics statistics;
  statistics.remap(std::vector<int>(LinearFace::kMarkers, -1));
  for (int f = 0; f < frames; ++f) {
    face.next();
    statistics.observe(face.measured, face.visible);
    statistics.learn(1.0 / 60);
  }
  return statistics;
}

TEST(MarkerStatistics, PredictsAHiddenMarkerFromTheOthers) {
  LinearFace face(1);
  MarkerStatistics statistics = learnt(face, 1000);
  double squared = 0;
  for (int f = 0; f < 200; ++f) {
    face.next();
    face.visible[4] = 0;
    face.measured[4].setConstant(std::nan(""));
    statistics.observe(face.measured, face.visible);
    squared += (statistics.prediction_mm(4) - face.truth[4]).squaredNorm() / 200;
  }
  // The marker itself moves by about 3 * sqrt(2 * 3) = 7.3 mm; the doubt in the model costs a few percent (measured
  // 0.67).
  EXPECT_LT(std::sqrt(squared), 0.12 * 7.3);
}

TEST(MarkerStatistics, LeaveOneOutPredictionEqualsThatOfTheMarkerHidden) {
  LinearFace face(2);
  MarkerStatistics statistics = learnt(face, 333);
  face.next();
  statistics.observe(face.measured, face.visible);
  for (std::size_t i = 0; i < LinearFace::kMarkers; ++i) {
    const Eigen::Vector3d left_out = statistics.prediction_mm(i);
    const double variance = statistics.variance_mm2(i);
    statistics.hide(i);
    statistics.update();
    EXPECT_LT((statistics.prediction_mm(i) - left_out).norm(), 1e-8);
    EXPECT_NEAR(statistics.variance_mm2(i), variance, 1e-8 * variance);
    statistics.unhide(i);
    statistics.update();
  }
}

TEST(MarkerStatistics, KnowsLessWhenFewerAreVisible) {
  LinearFace face(3);
  MarkerStatistics statistics = learnt(face, 400);
  face.next();
  double last = 0;
  for (std::size_t hidden = 0; hidden < LinearFace::kMarkers; ++hidden) {
    face.visible[hidden] = 0;
    statistics.observe(face.measured, face.visible);
    EXPECT_GE(statistics.variance_mm2(0), last * (1 - 1e-9));
    last = statistics.variance_mm2(0);
  }
  EXPECT_GT(last, 1);  // nobody is left: the whole movement (several mm) is open
}

TEST(MarkerStatistics, StaysFiniteOverManyFramesThatNeverChange) {
  LinearFace face(4);
  MarkerStatistics statistics = learnt(face, 1);
  for (int f = 0; f < 20000; ++f) {
    statistics.observe(face.measured, face.visible);
    statistics.learn(1.0);
  }
  for (std::size_t i = 0; i < LinearFace::kMarkers; ++i) {
    EXPECT_LT((statistics.prediction_mm(i) - face.measured[i]).norm(), 1e-6);
    EXPECT_TRUE(std::isfinite(statistics.variance_mm2(i)));
  }
}

TEST(MarkerStatistics, RejectsOptionsOutOfRange) {
  EXPECT_THROW(MarkerStatistics({.noise_floor_mm = 0}), UserError);
  EXPECT_THROW(MarkerStatistics({.model_doubt = 0.5}), UserError);
}

// A held expression while a marker is hidden: blocks that leave the hidden marker out would teach that it stays while
// the others move, and the prediction would creep back to rest.
TEST(MarkerStatistics, AHiddenMarkerIsNotTaughtToStayWhileTheOthersMove) {
  constexpr std::size_t kMarkers = 12, kHidden = 3;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Eigen::Vector3d> rest, mode, position(kMarkers);
  for (std::size_t i = 0; i < kMarkers; ++i) {
    rest.emplace_back(60 * normal(random), 60 * normal(random), 30 * normal(random));
    mode.emplace_back(normal(random), normal(random), normal(random));
  }
  MarkerStatistics statistics;
  statistics.remap(std::vector<int>(kMarkers, -1));
  std::vector<std::uint8_t> visible(kMarkers, 1);
  for (int f = 0; f < 700; ++f) {
    const double z = f < 400 ? std::sin(0.07 * f) : 3;
    visible[kHidden] = f < 400;
    for (std::size_t i = 0; i < kMarkers; ++i) {
      position[i] = rest[i] + z * mode[i] + 0.05 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    }
    statistics.observe(position, visible);
    statistics.learn(1.0 / 60);
  }
  const double moved = 3 * mode[kHidden].norm();
  EXPECT_LT((statistics.prediction_mm(kHidden) - position[kHidden]).norm(), 0.1 * moved);
}

}  // namespace
}  // namespace risorius
