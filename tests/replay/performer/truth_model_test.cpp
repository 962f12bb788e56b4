#include "replay/performer/truth_model.h"

#include <gtest/gtest.h>
#include <stdexcept>

#include "solve/faces/builtin_face.h"

namespace {

using namespace risorius;

const Rig& rig() {
  static const Rig built = builtin_rig();
  return built;
}

double rms(const Eigen::Matrix3Xd& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<double>(difference.cols()));
}

/// Share of the basis's energy that differs.
double basis_difference(const Rig& other) {
  double different = 0, all = 0;
  for (std::size_t k = 0; k < rig().au_count(); ++k) {
    different += (other.aus[k].displacement_mm - rig().aus[k].displacement_mm).squaredNorm();
    all += rig().aus[k].displacement_mm.squaredNorm();
  }
  return std::sqrt(different / all);
}

TEST(TruthModel, WithoutPerturbationIsTheRig) {
  TruthModel model(rig(), {}, 120, 1);
  std::vector<double> x(rig().au_count(), 0);
  x[0] = 0.7;
  x[3] = 1;
  Eigen::Matrix3Xd head_mm = rig().neutral_mm;
  model.pose_next(x, head_mm);
  const Eigen::Matrix3Xd expected =
      rig().neutral_mm + 0.7 * rig().aus[0].displacement_mm + rig().aus[3].displacement_mm;
  EXPECT_LT((head_mm - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(TruthModel, PerturbsByWhatWasAsked) {
  double identity = 0, basis = 0, placement = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    identity += rms(TruthModel(rig(), {.identity_mm = 4}, 120, seed).rig().neutral_mm - rig().neutral_mm) / kSeeds;
    basis += basis_difference(TruthModel(rig(), {.basis_share = 0.15}, 120, seed).rig()) / kSeeds;
    placement += rms(TruthModel(rig(), {.placement_mm = 2}, 120, seed).rig().neutral_mm - rig().neutral_mm) / kSeeds;
  }
  EXPECT_NEAR(identity, 4, 1e-6);
  EXPECT_NEAR(placement, 2 * std::sqrt(3.0), 0.3);  // per axis
  EXPECT_GT(basis, 0.10);
  EXPECT_LT(basis, 0.20);
}

TEST(TruthModel, PlacementCarriesTheDisplacementsAlong) {
  const TruthModel model(rig(), {.placement_mm = 2}, 120, 3);
  const double difference = basis_difference(model.rig());
  EXPECT_GT(difference, 0.005);
  EXPECT_LT(difference, 0.25);  // 2 mm beside a marker the field is not another one
}

TEST(TruthModel, SlideBendsTheWayAndNotItsEnds) {
  TruthModel model(rig(), {.slide_share = 0.1}, 120, 3);
  Eigen::Matrix3Xd at = rig().neutral_mm, half = at, end = at;
  std::vector<double> x(rig().au_count(), 0);
  model.pose_next(x, at);
  x[0] = 0.5;
  model.pose_next(x, half);
  x[0] = 1;
  model.pose_next(x, end);
  EXPECT_LT((at - rig().neutral_mm).norm(), 1e-9);
  EXPECT_LT((end - at - rig().aus[0].displacement_mm).norm(), 1e-9);
  const double bend = (half - at - 0.5 * rig().aus[0].displacement_mm).norm();
  EXPECT_NEAR(bend / rig().aus[0].displacement_mm.norm(), 0.1, 0.01);
}

TEST(TruthModel, CreepsSlowlyAndTheSameAgainAfterRewind) {
  TruthModel model(rig(), {.creep_mm = 0.3}, 60, 5);
  const std::vector<double> x(rig().au_count(), 0);
  Eigen::Matrix3Xd last = rig().neutral_mm, head_mm = last;
  double squares = 0, steps = 0;
  constexpr int kFrames = 60 * 600;
  for (int f = 0; f < kFrames; ++f) {
    model.pose_next(x, head_mm);
    squares += (head_mm - rig().neutral_mm).squaredNorm();
    steps = std::max(steps, (head_mm - last).cwiseAbs().maxCoeff());
    last = head_mm;
  }
  // 600 s of a 20 s memory: about 15 independent looks at each of 165 coordinates.
  EXPECT_NEAR(std::sqrt(squares / (static_cast<double>(kFrames) * 3.0 * static_cast<double>(rig().marker_count()))),
              0.3, 0.03);
  EXPECT_LT(steps, 0.1);
  model.rewind();
  for (int f = 0; f < kFrames; ++f) model.pose_next(x, head_mm);
  EXPECT_EQ(head_mm, last);
}

TEST(TruthModel, RefusesOptionsOutOfRange) {
  EXPECT_THROW(TruthModel(rig(), {.identity_mm = -1}, 120, 1), std::invalid_argument);
  EXPECT_THROW(TruthModel(rig(), {.basis_share = 0.6}, 120, 1), std::invalid_argument);
  EXPECT_THROW(TruthModel(rig(), {.placement_mm = 11}, 120, 1), std::invalid_argument);
}

}  // namespace
