#include "capture/repair/symmetric_sweep.h"

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <random>

#include "capture/repair/cholesky.h"

namespace risorius {
namespace {

Eigen::MatrixXd inverse_of(Eigen::MatrixXd a) {
  Eigen::MatrixXd inverse(a.rows(), a.cols());
  Eigen::VectorXd column(a.rows());
  for (Eigen::Index pivot = 0; pivot < a.cols(); ++pivot) sweep_pivot(a, pivot, column);
  negate_whole(a, inverse);
  return inverse;
}

Eigen::MatrixXd positive_definite(Eigen::Index size, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Eigen::MatrixXd root(size, size);
  for (double& x : root.reshaped()) x = normal(random);
  return root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
}

TEST(SymmetricSweep, GivesTheInverseOfAnySizeSymmetricToTheBit) {
  for (const Eigen::Index size : {0, 1, 2, 7, 60}) {
    const Eigen::MatrixXd a = positive_definite(size, 3);
    const Eigen::MatrixXd inverse = inverse_of(a);
    EXPECT_EQ(inverse, inverse.transpose()) << size;
    EXPECT_LT((a * inverse - Eigen::MatrixXd::Identity(size, size)).norm(), 1e-9) << size;
  }
}

TEST(SymmetricSweep, ReadsTheLowerTriangleOnly) {
  const Eigen::MatrixXd a = positive_definite(9, 4);
  Eigen::MatrixXd lower = a;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
  EXPECT_EQ(inverse_of(lower), inverse_of(a));
}

TEST(Cholesky, SolvesWithTheFactorItLeavesInPlace) {
  for (const Eigen::Index size : {1, 3, 36}) {
    const Eigen::MatrixXd a = positive_definite(size, 5);
    Eigen::MatrixXd room = a;
    Eigen::Map<Eigen::MatrixXd> factor(room.data(), size, size);
    factorize_lower(factor);
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(size, -1, 2);
    Eigen::VectorXd x = right;
    const Eigen::Map<const Eigen::MatrixXd> lower(room.data(), size, size);
    solve_lower(lower, x);
    solve_lower_transposed(lower, x);
    EXPECT_LT((a * x - right).norm(), 1e-9) << size;
  }
}

}  // namespace
}  // namespace risorius
