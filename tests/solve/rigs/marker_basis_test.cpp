#include "solve/rigs/marker_basis.h"

#include <gtest/gtest.h>
#include <random>

#include "support/allocation_counter.h"
#include "synthetic_face.h"

namespace risorius {
namespace {

constexpr int kMarkers = 41, kAus = 15;

/// 3M x K, straight from the rig.
Eigen::MatrixXd dense_basis(const Rig& rig) {
  Eigen::MatrixXd e(3 * kMarkers, kAus);
  for (int i = 0; i < kAus; ++i) e.col(i) = rig.aus[i].displacement_mm.reshaped();
  return e;
}

Eigen::MatrixXd dense_gram(const Rig& rig, const Eigen::VectorXd& weight) {
  const Eigen::MatrixXd e = dense_basis(rig);
  const Eigen::VectorXd per_axis = weight.transpose().replicate(3, 1).reshaped();
  return e.transpose() * per_axis.asDiagonal() * e;
}

TEST(MarkerBasis, GramIsTheWeightedSumHoweverManyMarkersDiffer) {
  const Rig rig = test::synthetic_rig(kMarkers, kAus);
  MarkerBasis basis(rig);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  Eigen::MatrixXd h(kAus, kAus);
  for (const bool some_always_missing : {false, true}) {
    if (some_always_missing) {
      Eigen::VectorXd usual = Eigen::VectorXd::Ones(kMarkers);
      usual.head(9).setZero();
      basis.use_weights(usual);
    }
    for (int differing = 0; differing <= kMarkers; ++differing) {
      Eigen::VectorXd weight = Eigen::VectorXd::Ones(kMarkers);
      for (int m = 0; m < differing; ++m) weight[m] = m % 3 == 0 ? 0 : uniform(random);
      basis.gram(weight, h);
      const Eigen::MatrixXd expected = dense_gram(rig, weight);
      EXPECT_LE((h - expected).cwiseAbs().maxCoeff(), 1e-12 * basis.mean_diagonal_mm2() * kMarkers) << differing;
      EXPECT_TRUE(h == h.transpose());
    }
  }
}

TEST(MarkerBasis, ProjectAndDeformAreTransposes) {
  const Rig rig = test::synthetic_rig(kMarkers, kAus);
  const MarkerBasis basis(rig);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(kAus, 0, 1), v = Eigen::VectorXd::LinSpaced(3 * kMarkers, -3, 2);
  Eigen::VectorXd displacement(3 * kMarkers), b(kAus);
  basis.deform(x, displacement);
  basis.project(v, b);
  EXPECT_LE((displacement - dense_basis(rig) * x).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(v.dot(displacement), b.dot(x), 1e-9);
}

TEST(MarkerBasis, VisibleShareIsOneWithAllMarkersAndFallsWithEach) {
  const Rig rig = test::synthetic_rig(kMarkers, kAus);
  const MarkerBasis basis(rig);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(kMarkers), share(kAus), before(kAus);
  basis.visible_share(weight, before);
  EXPECT_LE((before.array() - 1).abs().maxCoeff(), 1e-12);
  for (int m = 0; m < kMarkers; ++m) {
    weight[m] = 0;
    basis.visible_share(weight, share);
    EXPECT_TRUE((share.array() <= before.array() + 1e-15).all());
    before = share;
  }
  EXPECT_LE(share.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(MarkerBasis, AllocatesNothing) {
  const MarkerBasis basis(test::synthetic_rig(kMarkers, kAus));
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(kMarkers), x = Eigen::VectorXd::Ones(kAus), share(kAus), b(kAus);
  Eigen::VectorXd displacement(3 * kMarkers);
  Eigen::MatrixXd h(kAus, kAus);
  const std::uint64_t before = test::allocations_of_this_thread();
  for (int m = 0; m < kMarkers; ++m) {
    weight[m] = 0.5;
    basis.gram(weight, h);
    basis.deform(x, displacement);
    basis.project(displacement, b);
    basis.visible_share(weight, share);
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
