#include "solve/faces/similarity.h"

#include <gtest/gtest.h>

namespace {

using risorius::fit_similarity;
using risorius::Similarity;
using risorius::SimilarityFit;

/// Five points that are not flat.
Eigen::Matrix3Xd points() {
  Eigen::Matrix3Xd p(3, 5);
  p << 30, -30, 0, 25, -25,  //
      35, 35, 0, -40, -42,   //
      80, 82, 120, 95, 96;
  return p;
}

Eigen::Matrix3Xd moved(const Similarity& s, const Eigen::Matrix3Xd& p) {
  Eigen::Matrix3Xd result(3, p.cols());
  for (Eigen::Index i = 0; i < p.cols(); ++i) result.col(i) = s * p.col(i);
  return result;
}

const Similarity kMotion{
    Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized())), {100, -40, 7}, 1.7};

TEST(Similarity, RecoversTheMotionThatWasApplied) {
  const SimilarityFit fit = fit_similarity(points(), moved(kMotion, points()), Eigen::VectorXd::Ones(5));
  ASSERT_TRUE(fit.determined);
  EXPECT_NEAR(fit.to_from.scale, 1.7, 1e-12);
  EXPECT_LT(fit.to_from.rotation.angularDistance(kMotion.rotation), 1e-7);
  EXPECT_LT((fit.to_from.translation - kMotion.translation).norm(), 1e-10);
  EXPECT_LT(fit.rms, 1e-10);
}

TEST(Similarity, InverseUndoesIt) {
  const Eigen::Vector3d p(3, -8, 21);
  EXPECT_LT((kMotion.inverse() * (kMotion * p) - p).norm(), 1e-12);
}

TEST(Similarity, NeverMirrors) {
  Eigen::Matrix3Xd mirrored = points();
  mirrored.row(0) *= -1;
  mirrored(0, 3) += 4;  // not its own mirror image
  const SimilarityFit fit = fit_similarity(points(), mirrored, Eigen::VectorXd::Ones(5));
  EXPECT_NEAR(fit.to_from.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  EXPECT_GT(fit.rms, 5);
}

TEST(Similarity, IgnoresPointsOfWeightZero) {
  Eigen::Matrix3Xd to = moved(kMotion, points());
  to.col(2) += Eigen::Vector3d(500, 0, 0);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(5);
  weights[2] = 0;
  EXPECT_LT(fit_similarity(points(), to, weights).rms, 1e-10);
}

TEST(Similarity, NoSimilarityIsBetter) {
  Eigen::Matrix3Xd to = moved(kMotion, points());
  to(0, 1) += 6;
  to(2, 4) -= 9;
  const SimilarityFit fit = fit_similarity(points(), to, Eigen::VectorXd::Ones(5));
  const auto rms_of = [&](const Similarity& s) {
    return std::sqrt((moved(s, points()) - to).colwise().squaredNorm().mean());
  };
  EXPECT_NEAR(rms_of(fit.to_from), fit.rms, 1e-9);
  for (const double sign : {-1.0, 1.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      Similarity other = fit.to_from;
      other.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(sign * 1e-3, Eigen::Vector3d::Unit(axis))) * other.rotation;
      EXPECT_GT(rms_of(other), fit.rms);
      other = fit.to_from;
      other.translation[axis] += sign * 0.1;
      EXPECT_GT(rms_of(other), fit.rms);
    }
    Similarity other = fit.to_from;
    other.scale += sign * 1e-3;
    EXPECT_GT(rms_of(other), fit.rms);
  }
}

TEST(Similarity, SaysThatALineOrAPointDeterminesNothing) {
  Eigen::Matrix3Xd line(3, 4);
  line << 0, 1, 2, 3, 0, 2, 4, 6, 0, -1, -2, -3;
  EXPECT_FALSE(fit_similarity(line, 2 * line, Eigen::VectorXd::Ones(4)).determined);
  const Eigen::Matrix3Xd point = Eigen::Matrix3Xd::Constant(3, 4, 5);
  EXPECT_FALSE(fit_similarity(points().leftCols(4), point, Eigen::VectorXd::Ones(4)).determined);
  EXPECT_FALSE(fit_similarity(points(), points(), Eigen::VectorXd::Zero(5)).determined);
}

}  // namespace
