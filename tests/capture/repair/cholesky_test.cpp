#include "capture/repair/cholesky.h"

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

Eigen::MatrixXd positive_definite(Eigen::Index size, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Eigen::MatrixXd root(size, size);
  for (double& x : root.reshaped()) x = normal(random);
  return root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
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
